"""Openings on the annotated real facades of the shared data, scored by their own scorers."""

import importlib.util
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from _common import DATA, table
from _houses import openings_of
from frontage.buildings import find_buildings
from frontage.facades import find_facades
from frontage.geometry.arrays import Float
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import DOORS, Facade, Scan
from frontage.model.scan import merge_scans


@dataclass(frozen=True)
class Front:
    """A real scan of the shared data: its file, the truths of facades in it, and its sensor's path."""

    path: str
    truths: tuple[str, ...]
    trajectory: str | None = None


FRONTS = {
    "brooklyn_row": Front("brooklyn_row/street_front.laz", ("brooklyn_row",)),
    "manhattan_apartment": Front("manhattan_apartment/street_front.laz", ("manhattan_apartment",)),
    "museum_south": Front("museum_south/museum_south.laz", ("museum_south",)),
    "church_tower": Front("church_tower/church_tower.laz", ("church_tower",)),
    "lille_mobile": Front("lille_mobile/Lille_street_small.ply", ("lille_mobile",)),
    "clocktower": Front("clocktower/clocktower_enu.laz", ("clocktower_f0", "clocktower_f3")),
    "ingolstadt_2cm": Front("ingolstadt_scene/input/registered/scan_2cm.e57", ()),
    "ingolstadt_mobile": Front(
        "ingolstadt_scene/input/mobile/mobile.laz", (), "ingolstadt_scene/input/mobile/trajectory.csv"
    ),
}
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
    for name, front in FRONTS.items():
        if not (DATA / front.path).exists():
            print(f"{name}: shared data is absent and left out", file=sys.stderr)
        elif front.truths:
            lines += annotated(front, methods)
    lines += scene(methods)
    if lines:
        table("Real fronts, and the scene of real buildings", (*COLUMNS, COST), lines)


def read_front(front: Front) -> Scan:
    """Read a scan of the shared data as one cloud."""
    source = {"path": str(DATA / front.path)}
    if front.trajectory:
        source["trajectory"] = str(DATA / front.trajectory)
    return merge_scans(read_scans(ScanSource.model_validate(source)))


def annotated(front: Front, methods: Sequence[str]) -> list[list[Any]]:
    """Return the table rows of a scan with truths."""
    scan, lines = read_front(front), []
    facades = fronts(scan)
    for method in methods:
        found, _, _, seconds = openings_of(facades, scan, method)
        for truth in front.truths:
            told = judged_rings([(o.kind, o.ring) for o in found], scan, read_truth(truth))
            numbers = [f"{told[f'f1@{level}']:.3f}" for level in LEVELS]
            borders = [told.get("border_median_cm", "-"), told.get("border_p90_cm", "-")]
            lines.append(
                [truth, method, *numbers, told["asked"], told["predicted"], *borders, f"{seconds:.1f}"]
            )
    return lines


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


def read_truth(name: str) -> dict[str, Any]:
    """Read the annotation of a facade."""
    truth: dict[str, Any] = json.loads((DATA / "truth" / f"{name}.json").read_text())
    return truth


def judged_rings(found: Sequence[tuple[str, Float]], scan: Scan, truth: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of the annotation's own scorer for kinds and rings (k, 3) m local."""
    entries = [{"kind": kind, "outline_world": scan.world.to_world(ring).tolist()} for kind, ring in found]
    scorer = DATA / "truth" / "score_real.py"
    with tempfile.TemporaryDirectory() as folder:
        path, asked = Path(folder) / "facades" / "all" / "openings.json", Path(folder) / "truth.json"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps({"openings": entries}))
        asked.write_text(json.dumps(truth))
        command = [sys.executable, str(scorer), folder, str(asked)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    told: dict[str, Any] = json.loads(done.stdout)
    return told
