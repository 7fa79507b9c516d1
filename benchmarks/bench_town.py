"""Openings and LoD3 solids of simulated scans of real buildings, ours and the paper's method.

    python benchmarks/bench_town.py [--methods paper evidence] [--only developed unseen] [--scenes FOLDER]

Groups of the twelve LoD3 buildings of Ingolstadt are scanned by one to three stations, 2 or 4 cm apart,
behind trees, cars and people, and go through the whole chain with their LoD2 model. `developed` = buildings
that were looked at while the method was built, `unseen` = buildings that were set aside, `scene` = those of
`ingolstadt_scene`, which were set aside as well. Openings of which a station saw at least half are asked for;
windows lie as deep as in the model, often 1 to 3 cm. `not in the solid` counts openings with a confidence of
0.5 or more that the LoD3 model lacks. Intervals: 95 %, bootstrap over facades.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from _changes import sightless
from _common import DATA, table
from bench_openings import LEVELS, f1_over
from frontage.evaluation.openings import score_openings
from frontage.evaluation.truth import Truth, best_share
from frontage.geometry.arrays import Float
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.read import read_scans
from frontage.model import Scan
from frontage.model.scan import merge_scans
from frontage.pipeline.project import make_project
from frontage.pipeline.run import run
from frontage.simulate.spec import SceneSpec
from frontage.studies.runresults import Results
from frontage.studies.score import load_truth
from frontage.studies.simulate import simulate

MODELS = DATA / "citymodels" / "ingolstadt_lod3"
HALF, SURE = 0.5, 0.5  # share of an opening that a station must have seen; confidence that must be built
SENSORS = ("stations",)


@dataclass(frozen=True)
class Town:
    """Buildings and how they are scanned: seed, stations, m between beams 10 m away, things before them."""

    buildings: str
    seed: int
    stations: int
    spacing: float
    cars: int = 2
    trees: int = 1
    people: int = 2

    def spec(self, name: str) -> SceneSpec:
        """Return the specification of the scene."""
        scanner = {"stations": self.stations, "spacing": self.spacing}
        traffic = {"cars": self.cars, "trees": self.trees, "people": self.people}
        files = [f"{number}.xml" for number in self.buildings.split()]
        about = {"name": name, "seed": self.seed, "from_model": files, "scanners": [scanner], "cameras": []}
        return SceneSpec.model_validate(about | traffic)


TOWNS: dict[str, dict[str, Town]] = {
    "developed": {
        "d1": Town("4018257 4018258", 301, 2, 0.02, cars=3, trees=2, people=3),
        "d2": Town("4018257 4018258", 302, 2, 0.04, cars=4, trees=1, people=3),
        "d3": Town("4018152b 4018194", 303, 2, 0.02),
        "d4": Town("4018258", 304, 1, 0.04),
        "d5": Town("4018152b 4018260", 305, 2, 0.04),
    },
    "unseen": {
        "h1": Town("4018267", 311, 3, 0.02, cars=3),
        "h2": Town("4018270", 312, 2, 0.04, cars=3, trees=2, people=3),
        "h3": Town("4018267", 313, 1, 0.04),
    },
    "scene": {
        "h4": Town("4018262 4018115", 314, 3, 0.02, cars=3),
        "h5": Town("4018150a 4018150b", 315, 2, 0.04),
    },
}


@dataclass(frozen=True)
class Found:
    """What a method found in a scene.

    counts  by IoU: found and true, found but not true, missed (n, 3), a row for every true facade and one for
            what lies on none
    sure    openings with enough confidence; lost = those of them that the solid lacks
    solid   counts of the solid's openings
    """

    counts: Mapping[float, Float]
    solid: Mapping[float, Float]
    sure: int
    lost: tuple[str, ...]


def measured(scene: Path, out: Path, method: str, bare: bool = False) -> Found:
    """Run the chain on the scans and the LoD2 model of a scene, and score it.

    `bare`: on one cloud without sensor positions, and without the LoD2 model.
    """
    scans = [bare_cloud(scene)] if bare else sorted((scene / "scans").glob("*.e57"))
    parts: dict[str, Any] = {"scans": [{"path": str(path)} for path in scans], "openings": {"method": method}}
    if not bare:
        parts["model"] = {"path": str(scene / "lod2.city.json")}
    about = {"name": scene.name, "crs": "EPSG:32632"}
    run(make_project({"project": about, **parts}, scene, "the benchmark"), out)
    truth, base = load_truth(scene)
    results = Results(out, truth, base)
    told = [results.openings(), results.model()]
    counts, solid = (by_facade(truth, found if isinstance(found, list) else []) for found in told)
    sure = [name for name, confidence in claims(out) if confidence >= SURE]
    text = (out / "model" / "lod3.city.json").read_text("utf-8")
    return Found(counts, solid, len(sure), tuple(name for name in sure if f'"{name}"' not in text))


def bare_cloud(scene: Path) -> Path:
    """Write the scans of a scene as one cloud without sensor positions; return its path."""
    scans: list[Scan] = []
    for path in sorted((scene / "scans").glob("*.e57")):
        scans += read_scans(str(path), world=scans[0].world if scans else None)
    return write_las(scene / "cloud.laz", sightless(merge_scans(scans)).scan)


def claims(out: Path) -> Iterator[tuple[str, float]]:
    """Yield the id and confidence of every opening of a run."""
    for path in sorted(out.glob("facades/*/openings.json")):
        for opening in json.loads(path.read_text("utf-8")):
            yield opening["id"], float(opening["confidence"])


def by_facade(truth: Truth, found: list[Any]) -> dict[float, Float]:
    """Count openings by IoU and true facade; the last row is what has no true opening."""
    home = {o.id: k for k, f in enumerate(truth.facades) for o in f.openings}
    asked = {o.id: best_share(o.visible, SENSORS) >= HALF for f in truth.facades for o in f.openings}
    counts = {level: np.zeros((len(truth.facades) + 1, 3)) for level in LEVELS}
    for row in score_openings(truth, found, SENSORS).items:
        iou, there = row.get("iou") or 0.0, row.get("found") is not None
        for level in LEVELS:
            if "id" not in row:
                counts[level][-1] += (0, 1, 0)
            elif asked[row["id"]]:
                hit = iou >= level
                counts[level][home[row["id"]]] += (hit, there and not hit, not hit)
            elif there and iou < HALF * HALF:
                counts[level][home[row["id"]]] += (0, 1, 0)
    return {level: rows[rows.sum(1) > 0] for level, rows in counts.items()}


def line(kind: str, method: str, found: list[Found]) -> list[str]:
    """Return the row of the table of one kind of scenes."""

    def score(level: float, part: str) -> str:
        return f1_over(np.concatenate([getattr(one, part)[level] for one in found]))

    total = np.concatenate([one.counts[LEVELS[0]] for one in found]).sum(0).astype(int)
    lost, sure = sum(len(one.lost) for one in found), sum(one.sure for one in found)
    openings = [score(level, "counts") for level in LEVELS]
    solids = [score(level, "solid") for level in LEVELS]
    return [kind, method, *openings, *map(str, total), *solids, f"{lost} of {sure}"]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--methods", nargs="+", default=["paper", "evidence"])
    parser.add_argument("--only", nargs="+", default=list(TOWNS), choices=list(TOWNS))
    parser.add_argument("--scenes", type=Path, help="where simulated scenes are kept")
    given = parser.parse_args()
    if not MODELS.exists():
        sys.exit("the LoD3 models of the shared data are absent")
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.scenes or Path(temporary)
        for kind in given.only:
            made = {n: simulate(t.spec(n), folder / n, base=MODELS).out for n, t in TOWNS[kind].items()}
            for method in given.methods:
                found = []
                for name, scene in made.items():
                    found.append(measured(scene, Path(temporary) / f"{name} {method}", method))
                    print(" | ".join(line(name, method, found[-1:])), file=sys.stderr, flush=True)
                rows.append(line(kind, method, found))
    head = ("buildings", "method", "F1 at 0.5", "F1 at 0.75", "true", "false", "missed")
    solid = ("solid at 0.5", "solid at 0.75", "not in the solid")
    table("Simulated scans of real buildings", (*head, *solid), rows)


if __name__ == "__main__":
    main()
