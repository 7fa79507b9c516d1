"""The whole chain on a street, and its windows beside the true ones.

Simulates two houses, runs the chain with one call, opens the run folder, and prints the size and the depth of
every opening of the first house with standard errors beside the truth. The feet of both doors are hidden,
which their sigmas tell. In a notebook, `frontage.open_run(...)` shows the pictures of the run.
"""

import json
import tempfile
from pathlib import Path

import numpy as np

import frontage
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate

SPEC = """
seed = 11
opposite = false
setting = "terrace"
trees = 0
cars = 1
people = 0
[[house]]
floors = 3
[[house]]
floors = 2
[[scanners]]
stations = 2
spacing = 0.06
subrays = 1
field = 180.0
lowest = -35.0
highest = 55.0
[[cameras]]
width = 300
height = 360
samples = 1
most = 1
pitches = [16.0]
[output]
gsd = 0.04
"""


def true_openings(scene: Path) -> list[dict]:
    """The true openings of all facades, with the middle of each in the world."""
    truth = json.loads((scene / "truth" / "truth.json").read_text())
    openings = [opening for facade in truth["facades"] for opening in facade["openings"]]
    return [one | {"middle": middle(one["outline_world"])} for one in openings]


def middle(corners: list) -> np.ndarray:
    """The middle of the box around corners (k, 3)."""
    points = np.array(corners)
    return (points.min(axis=0) + points.max(axis=0)) / 2


def size(outline: list) -> np.ndarray:
    """Width and height in m of an outline (k, 2) in the facade frame."""
    points = np.array(outline)
    return points.max(axis=0) - points.min(axis=0)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        scene, out = Path(folder) / "scene", Path(folder) / "result"
        simulate(parse_spec(SPEC), scene)
        frontage.run(scene / "project.toml", out)
        run = frontage.open_run(out)
        print(run)
        truth = true_openings(scene)
        facade = run.facades[0]
        header = f"{'true size, m':>16}{'found size, m':>16}{'sigmas, m':>16}{'true depth':>12}{'found':>8}"
        print(f"{facade:14}{header}")
        errors: list[float] = []
        for opening in run.openings(facade).openings:
            found = run.locate(opening.id)
            true = min(truth, key=lambda one: np.linalg.norm(one["middle"] - np.array(found.center)))
            width, height = size(true["outline"])
            errors += [found.width - width, found.height - height]
            columns = (width, height, found.width, found.height, found.sigma["width"], found.sigma["height"])
            depth = "-" if found.depth is None else f"{found.depth:.3f}"
            print(
                f"{found.id:14}" + "".join(f"{v:8.3f}" for v in columns) + f"{true['depth']:12.3f}{depth:>8}"
            )
    print(f"{len(errors) // 2} openings: median size error {np.median(np.abs(errors)) * 1000:.1f} mm")


if __name__ == "__main__":
    main()
