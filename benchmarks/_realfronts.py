"""Openings on the annotated real facades of the shared data, scored by their own scorers."""

import importlib.util
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from _common import DATA, table
from _houses import openings_of
from frontage.buildings import find_buildings
from frontage.evaluation.result import FoundOpening
from frontage.facades import find_facades
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import DOORS, Facade, Scan
from frontage.model.scan import merge_scans

REAL = ("brooklyn_row", "manhattan_apartment")
SCENE = ("registered/scan_2cm.e57", "registered/scan_4cm.laz", "mobile/mobile.laz")
LEVELS = (0.5, 0.75)
COLUMNS = ("front", "method", "F1 at 0.5", "F1 at 0.75", "asked", "found", "border cm", "90 % cm")
COST = "processor s per million points"


def fronts(scan: Scan) -> list[tuple[Facade, float]]:
    """Find the facades of a real scan and the heights of the ground, as a run does."""
    return [
        (f, building.ground_z)
        for building in find_buildings(scan).buildings
        for f in find_facades(scan, building)
        if isinstance(f, Facade)
    ]


def real(methods: Sequence[str]) -> None:
    """Print the tables of the annotated facades and of the complete scene."""
    lines = []
    for name in REAL:
        truth = DATA / "truth" / f"{name}.json"
        if not truth.exists():
            print(f"{name}: shared data is absent and left out", file=sys.stderr)
            continue
        (scan,) = read_scans(ScanSource(path=str(DATA / name / "street_front.laz")))
        facades = fronts(scan)
        for method in methods:
            found, _, _, seconds = openings_of(facades, scan, method)
            told = judged(found, scan, truth)
            numbers = [f"{told[f'f1@{level}']:.3f}" for level in LEVELS]
            borders = [told.get("border_median_cm", "-"), told.get("border_p90_cm", "-")]
            lines.append(
                [name, method, *numbers, told["asked"], told["predicted"], *borders, f"{seconds:.1f}"]
            )
    lines += scene(methods)
    if lines:
        table("Real fronts, and the scene of real buildings", (*COLUMNS, COST), lines)


def scene(methods: Sequence[str]) -> list[list[Any]]:
    """Return the table rows of the registered scans of `ingolstadt_scene`, by its scorer."""
    folder = DATA / "ingolstadt_scene"
    if not folder.exists():
        print("ingolstadt_scene: shared data is absent and left out", file=sys.stderr)
        return []
    spec = importlib.util.spec_from_file_location("score_scene", folder / "score_scene.py")
    assert spec is not None and spec.loader is not None
    scorer: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scorer)
    truth = scorer.load_truth(folder / "truth" / "truth.json")
    lines = []
    for name in SCENE:
        path = folder / "input" / name
        trajectory = path.with_name("trajectory.csv") if name.startswith("mobile") else None
        source = {"path": str(path)} | ({"trajectory": str(trajectory)} if trajectory else {})
        scan = merge_scans(read_scans(ScanSource.model_validate(source)))
        facades = fronts(scan)
        visible = "visible_mobile" if trajectory else "visible_tls"
        for method in methods:
            found, _, _, seconds = openings_of(facades, scan, method)
            claims = [
                {"kind": "Door" if o.kind in DOORS else "Window", "polygons": [scan.world.to_world(o.ring)]}
                | {"building": None, **({} if o.depth is None else {"depth": o.depth})}
                for o in found
            ]
            told = scorer.score_openings(claims, truth, visible)
            numbers = [f"{told[f'f1@{level}']:.3f}" for level in LEVELS]
            borders = [told["border_median_cm"], told["border_p90_cm"]]
            lines.append(
                [name, method, *numbers, told["n_truth"], told["n_pred"], *borders, f"{seconds:.1f}"]
            )
    return lines


def judged(found: Sequence[FoundOpening], scan: Scan, truth: Path) -> dict[str, Any]:
    """Return the figures of the annotation's own scorer."""
    entries = [{"kind": o.kind, "outline_world": scan.world.to_world(o.ring).tolist()} for o in found]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "facades" / "all" / "openings.json"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps({"openings": entries}))
        command = [sys.executable, str(truth.parent / "score_real.py"), folder, str(truth)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    told: dict[str, Any] = json.loads(done.stdout)
    return told
