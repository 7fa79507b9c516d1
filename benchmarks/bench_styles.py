"""Openings of fronts in twenty-eight styles, drawn at random: ours and the paper's method.

    python benchmarks/bench_styles.py [--draw 1] [--only arcade shops] [--spacing 0.02 0.04] [--bare]
                                      [--scenes FOLDER]

Each style is drawn from the seed `--draw`, so that fronts that nobody has seen are always at hand. Two
stations scan it behind cars, a tree and people, and the scans go through the whole chain with an LoD2 model
that is 15 cm off per axis and shows neither columns nor ornaments, or, `--bare`, as one cloud without sensor
positions and without a model. Openings of which a station saw at least half are asked for. `not in the
solid` counts openings with a confidence of 0.5 or more that the LoD3 model lacks. Intervals: 95 %, bootstrap
over facades.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from _common import table
from _drawn import Drawing
from _styles import STYLES
from bench_town import Found, line, measured
from frontage.simulate.spec import SceneSpec
from frontage.studies.simulate import simulate

COLUMNS = ("style", "method", "F1 at 0.5", "F1 at 0.75", "true", "false", "missed")
SOLID = ("solid at 0.5", "solid at 0.75", "not in the solid")


def drawn(style: str, draw: int, spacing: float, folder: Path) -> Path:
    """Draw a front and scan it; return the folder of the scene."""
    number = list(STYLES).index(style)
    rng, name = np.random.default_rng((draw, number)), f"{style}-{draw}"
    drawing = Drawing()
    STYLES[style](drawing, rng)
    folder.mkdir(parents=True, exist_ok=True)
    drawing.write(folder / f"{name}.city.json", name)
    about = {"name": name, "seed": 1000 * draw + number, "from_model": [f"{name}.city.json"], "cameras": []}
    about |= {"scanners": [{"stations": 2, "spacing": spacing}], "cars": 2, "trees": 1, "people": 2}
    scene = Path(simulate(SceneSpec.model_validate(about), folder / f"{name}-{spacing:g}", base=folder).out)
    drawing.write_lod2(scene / "lod2.city.json", name, rng)
    return scene


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--draw", type=int, default=1, help="seed of the fronts")
    parser.add_argument("--only", nargs="+", default=list(STYLES), choices=list(STYLES), metavar="STYLE")
    parser.add_argument("--spacing", nargs="+", type=float, default=[0.02], help="m between beams, 10 m away")
    parser.add_argument("--bare", action="store_true", help="without sensor positions and LoD2 model")
    parser.add_argument("--methods", nargs="+", default=["paper", "evidence"])
    parser.add_argument("--scenes", type=Path, help="where scenes and runs are kept")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.scenes or Path(temporary)
        for spacing in given.spacing:
            rows: dict[str, list[list[str]]] = {method: [] for method in given.methods}
            found: dict[str, list[Found]] = {method: [] for method in given.methods}
            for style in given.only:
                scene = drawn(style, given.draw, spacing, folder)
                for method in given.methods:
                    found[method].append(
                        measured(scene, folder / f"{scene.name} {method}", method, given.bare)
                    )
                    rows[method].append(line(style, method, found[method][-1:]))
                    print(" | ".join(rows[method][-1]), file=sys.stderr, flush=True)
            together = [line("together", method, found[method]) for method in given.methods]
            title = f"Fronts in {len(given.only)} styles, draw {given.draw}, {100 * spacing:g} cm"
            table(title, (*COLUMNS, *SOLID), [row for m in given.methods for row in rows[m]] + together)


if __name__ == "__main__":
    main()
