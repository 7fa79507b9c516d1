"""Scoring run folders: right ones, wrong ones, and what they do not hold."""

import json
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from frontage.errors import FileError, InputError, OptionError, WorkspaceError
from frontage.evaluation.metric import Absent, ScorePart
from frontage.evaluation.truth import TrueFacade, TrueOpening, Truth, read_truth
from frontage.geometry.rigid import Rigid3
from frontage.io.rasters.ortho import read_ortho, write_ortho
from frontage.pipeline.store.store import Store
from frontage.studies.score import Scores, parse_gate, score
from simulated import truth_of


@pytest.fixture
def copy(simulated_run: Path, tmp_path: Path) -> Path:
    """A run folder to spoil."""
    return Path(shutil.copytree(simulated_run, tmp_path / "run"))


@pytest.fixture(scope="module")
def truth(simulated: Path) -> Truth:
    return read_truth(truth_of(simulated))


def part(scores: Scores, name: str) -> ScorePart:
    found = scores.parts[name]
    assert isinstance(found, ScorePart), found
    return found


def value(scores: Scores, name: str) -> float:
    where, figure = name.split(".")
    found = part(scores, where).figures[figure].value
    assert found is not None
    return found


def test_what_the_chain_makes_is_scored_and_the_rest_is_absent(simulated_run: Path, simulated: Path) -> None:
    scores = score(simulated_run, simulated)
    assert value(scores, "buildings.f1") == 1.0 and value(scores, "facades.recall") == 1.0
    assert 0 < value(scores, "facades.offset_median") < 0.02  # the wall bulges, and has surrounds on it
    assert 0 < value(scores, "ortho.displacement_px_median") < 0.5
    assert abs(value(scores, "ortho.relief_bias")) < 0.002
    for name in ("photos", "scans"):
        assert isinstance(scores.parts[name], Absent)
    table = scores.table()
    assert set(table["absent"]) == {"photos", "scans"}
    assert "orientation/report.json" in table["absent"]["photos"]
    json.dumps(table, allow_nan=False)


def test_scores_repeat(simulated_run: Path, simulated: Path) -> None:
    assert score(simulated_run, simulated).table() == score(simulated_run, simulated / "truth").table()


def test_an_ortho_image_that_lies_elsewhere_fails(copy: Path, simulated: Path) -> None:
    folder = next((copy / "facades").iterdir())
    ortho = read_ortho(folder)
    moved = np.roll(ortho.pixels, 5, axis=1)  # 5 px of 2 cm to the right
    from dataclasses import replace

    write_ortho(folder, replace(ortho, pixels=moved))
    scores = score(copy, simulated)
    assert value(scores, "ortho.right_bias") == pytest.approx(0.10, abs=0.01)
    gate = parse_gate("ortho.displacement_px_median<=1")
    assert not gate.holds(scores)[0] and gate.holds(score(copy, simulated))[1].startswith("ortho.")


def test_a_plane_that_is_off_fails(copy: Path, simulated: Path) -> None:
    before = value(score(copy, simulated), "facades.offset_bias")
    path = next((copy / "facades").glob("*/facade.json"))
    record = json.loads(path.read_text())
    pose = record["local_from_facade"]
    inward = np.array(pose["R"])[:, 1]
    pose["t"] = (np.array(pose["t"]) + 0.2 * inward).tolist()
    path.write_text(json.dumps(record))
    scores = score(copy, simulated)
    assert value(scores, "facades.offset_bias") == pytest.approx(before - 0.2, abs=1e-4)
    assert value(scores, "facades.plane_normalised") > 10
    assert value(scores, "facades.plane_within_95") == 0.0


def test_points_of_no_building_cost_the_split(copy: Path, simulated: Path) -> None:
    path = next((copy / "buildings").glob("B*.index.npy"))
    np.save(path, np.load(path)[::3])
    scores = score(copy, simulated)
    assert value(scores, "buildings.iou") < 0.4 and value(scores, "buildings.f1") == 0.0


def entry(
    facade: TrueFacade, o: TrueOpening, world: np.ndarray, frame: Any, grow: float = 0.0
) -> dict[str, Any]:
    """What openings.json says of a true opening; `frame` = the found facade's, which bars are written in."""
    ring = np.column_stack([o.ring[:, 0], np.full(len(o.ring), o.wall_y), o.ring[:, 1]])
    ring[:, 0] += np.sign(ring[:, 0] - ring[:, 0].mean()) * grow
    bars: dict[str, list[Any]] = {"vertical": [], "horizontal": []}
    for b in o.bars:
        vertical = b.axis == "vertical"
        ends = [[b.position, 0, e] if vertical else [e, 0, b.position] for e in b.extent]
        (x0, _, z0), (x1, _, z1) = frame.inverse.apply(facade.frame.apply(np.array(ends, float)))
        at = {"position": x0, "extent": [z0, z1]} if vertical else {"position": z0, "extent": [x0, x1]}
        bars[b.axis].append(at)
    return {
        "id": o.id, "kind": o.kind, "shape": o.shape, "depth": o.depth, "bars": bars,
        "outline_world": (facade.frame.apply(ring) + world).tolist(),
        "sigma": {"border": 0.005, "depth": 0.01}, "provenance": "measured", "confidence": 1.0,
    }  # fmt: skip


def write_openings(run: Path, truth: Truth, grow: float = 0.0) -> None:
    store = Store(run)
    (name,) = store.facade_ids()
    (facade,) = [f for f in truth.facades if f.id == "B01/F1"]
    found = store.facade(name)
    at = truth.world.to_local(found.world.to_world(found.frame.t))
    frame = Rigid3("local", "facade", found.frame.R, at)
    rows = [entry(facade, o, truth.world.origin, frame, grow) for o in facade.openings]
    (store.facade_folder(name) / "openings.json").write_text(json.dumps(rows))


def test_openings_are_scored_when_there_are_any(copy: Path, simulated: Path, truth: Truth) -> None:
    write_openings(copy, truth)
    scores = score(copy, simulated)
    for name in ("f1_50", "f1_75", "kind_right", "shape_right", "bars_exact"):
        assert value(scores, f"openings.{name}") == 1.0, name
    assert value(scores, "openings.border_p95") < 1e-5
    write_openings(copy, truth, grow=0.04)
    grown = score(copy, simulated)
    assert value(grown, "openings.border_right_bias") == pytest.approx(0.04, abs=1e-4)
    assert value(grown, "openings.width_bias") == pytest.approx(0.08, abs=1e-4)
    assert value(grown, "openings.border_normalised") > 4


def test_the_true_lod3_model_scores_full_marks(copy: Path, simulated: Path) -> None:
    (copy / "model").mkdir(exist_ok=True)
    target = copy / "model" / "lod3.city.json"
    shutil.copy(simulated / "truth" / "lod3.city.json", target)
    scores = score(copy, simulated)
    for name in ("f1_50", "f1_75", "kind_right", "bars_exact"):
        assert value(scores, f"model.{name}") == 1.0, name
    assert value(scores, "model.border_p95") < 2e-4 and value(scores, "model.depth_median") < 1e-6
    model = json.loads(target.read_text())
    model["transform"]["translate"][2] += 0.1
    target.write_text(json.dumps(model))
    assert value(score(copy, simulated), "model.border_top_bias") == pytest.approx(0.1, abs=0.002)


def test_estimated_poses_are_scored(copy: Path, simulated: Path) -> None:
    table = truth_of(simulated)
    photos = []
    for p in table["photos"]:
        R, centre = np.array(p["true"]["R"]), np.array(p["true"]["center"]) + np.eye(3)[0] * 0.03
        pose = np.column_stack([R, -R @ centre]).tolist()
        photos.append({"photo": p["name"], "camera_from_world": pose, "center": centre.tolist(),
                       "sigma_center": [0.02] * 3, "sigma_angles": [0.01] * 3})  # fmt: skip
    (copy / "orientation").mkdir()
    (copy / "orientation" / "report.json").write_text(json.dumps(photos))
    scans = []
    for s, origin in zip(table["stations"], ("file", "scanner"), strict=True):
        matrix = np.eye(4)
        if origin == "scanner":
            matrix[:3, :3], matrix[:3, 3] = s["true"]["R"], s["true"]["position"]
        scans.append({"scan": f"{Path(s['file']).name}:1", "from": origin, "matrix": matrix.tolist(),
                      "covariance": np.eye(6).tolist()})  # fmt: skip
    (copy / "registration").mkdir()
    (copy / "registration" / "report.json").write_text(json.dumps(scans))
    scores = score(copy, simulated)
    assert value(scores, "photos.position_median") == pytest.approx(0.03, abs=1e-6)
    assert value(scores, "photos.after_shift_median") < 1e-6
    assert value(scores, "photos.position_normalised") == pytest.approx(1.5 / np.sqrt(3), abs=1e-3)
    assert value(scores, "scans.position_median") < 1e-6 and value(scores, "scans.recall") == 1.0


def test_gates_need_a_figure_to_hold(simulated_run: Path, simulated: Path) -> None:
    scores = score(simulated_run, simulated)
    assert parse_gate("facades.offset_median<=0.01").holds(scores)[0]
    kept, why = parse_gate("photos.found >= 1").holds(scores)
    assert not kept and "absent" in why
    kept, why = parse_gate("buildings.cut_median<=1").holds(scores)
    assert not kept and "nothing to compute" in why
    with pytest.raises(OptionError, match="no figure 'offset'"):
        parse_gate("facades.offset<=1").holds(scores)
    for text in ("facades.offset_median<1", "walls.f1>=1", "f1>=1", "facades.offset_median<=--1"):
        with pytest.raises(OptionError):
            parse_gate(text)


def test_what_cannot_be_scored_says_why(simulated: Path, copy: Path, tmp_path: Path) -> None:
    with pytest.raises(WorkspaceError, match="not a run folder"):
        score(tmp_path, simulated)
    with pytest.raises(FileError, match=r"truth\.json"):
        score(copy, tmp_path)
    path = copy / "facades" / "B01_F1" / "openings.json"
    path.write_text("{")
    with pytest.raises(InputError, match="openings cannot be scored"):
        score(copy, simulated)
    path.write_text(json.dumps([{"id": "W1", "kind": "window"}]))
    with pytest.raises(InputError, match="W1: lacks or garbles 'outline_world'"):
        score(copy, simulated)
    path.unlink()
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["stages"]["scans"]["world"]["crs"] = "EPSG:25833"
    (copy / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match="EPSG:25833"):
        score(copy, simulated)


def test_scans_that_the_truth_does_not_know_leave_the_split_unscored(copy: Path, simulated: Path) -> None:
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["project"]["scans"][0]["path"] = "elsewhere/other.e57"
    (copy / "manifest.json").write_text(json.dumps(manifest))
    scores = score(copy, simulated)
    absent = scores.parts["buildings"]
    assert isinstance(absent, Absent) and "other.e57" in absent.reason
    assert isinstance(scores.parts["facades"], ScorePart)


def test_a_spoilt_true_picture_is_named(copy: Path, simulated: Path, tmp_path: Path) -> None:
    scene = Path(shutil.copytree(simulated, tmp_path / "scene"))
    (picture,) = (scene / "truth").glob("ortho_*.png")
    picture.write_bytes(b"no picture")
    with pytest.raises(InputError, match=picture.name):
        score(copy, scene)
    assert cv2.imread(str(simulated / "truth" / picture.name)) is not None
