"""The demonstration: a small simulated street, the whole chain on it, and how well it did."""

from dataclasses import dataclass
from pathlib import Path

from frontage.pipeline.progress import Progress
from frontage.pipeline.project import load_project
from frontage.pipeline.run import Summary, run
from frontage.simulate.spec import parse_spec
from frontage.studies.score import Scores, score
from frontage.studies.simulate import Simulated, simulate

SPEC = """\
name = "demo"
seed = 11
houses = 3
setting = "terrace"
slope = 3.0

[[scanners]]            # two stations in the road
stations = 2
spacing = 0.035         # m between beams, 10 m away
field = 190.0
lowest = -35.0
highest = 50.0

[[cameras]]             # a walk along the other pavement
width = 2000
height = 2400
most = 4
pitches = [16.0]
"""


@dataclass(frozen=True)
class Demo:
    """What the demonstration made: the scene, the run, and its scores."""

    scene: Simulated
    run: Summary
    scores: Scores


def demo(out: Path, *, workers: int = 1, progress: Progress | None = None) -> Demo:
    """Simulate the street of `SPEC` into out/street and run the chain into out/result.

    A second call keeps the street and the stages of the run that are finished; why the street is simulated
    again, if the simulator has changed, is in the notes of the scene.

    Raises FrontageError as `simulate`, `run` and `score` do.
    """
    scene = simulate(parse_spec(SPEC, "the demo"), out / "street", workers=workers, progress=progress)
    made = run(load_project(scene.project), out / "result", workers=workers, progress=progress)
    return Demo(scene, made, score(out / "result", out / "street"))
