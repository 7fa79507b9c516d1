"""Free photos of a simulated street are oriented against its scans, within the chain."""

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from frontage.errors import FileError, FrontageError, MissingExtra
from frontage.geometry.rigid import rotation_angle
from frontage.io.colmap import read_colmap
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.model import Photo
from frontage.pipeline import run as chain
from frontage.pipeline.run import Summary, run, run_stage
from frontage.pipeline.store.orientation import load_key_points, load_matches, oriented_photos
from frontage.pipeline.store.store import Store
from orientation.orientedscene import (
    finished_run,
    imaging,
    only_orienting,
    pair_run,
    project_of,
    scene_of,
    some_photos,
    with_strangers,
)

pytest.importorskip("pycolmap")

KEYS = {
    "photo",
    "camera_from_world",
    "center",
    "sigma_center",
    "sigma_angles",
    "control_points",
    "tie_points",
    "check_rmse",
}


class Told:
    """Remembers which stages were kept."""

    def __init__(self) -> None:
        self.kept: dict[str, bool] = {}

    def begin(self, stage: str, total: int) -> None: ...

    def advance(self, stage: str) -> None: ...

    def end(self, stage: str, seconds: float, kept: bool, items: int) -> None:
        self.kept[stage] = kept


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scene_of(tmp_path_factory)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Summary]:
    return finished_run(tmp_path_factory)


@pytest.fixture
def out(finished: tuple[Path, Summary], tmp_path: Path) -> Path:
    """A copy of the finished run, to be damaged."""
    shutil.copytree(finished[0], tmp_path / "out")
    return tmp_path / "out"


def report(out: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads((out / "orientation" / "report.json").read_text())
    return table


def photos_of(scene: Path, out: Path, cameras: str) -> dict[str, Photo]:
    """The photos with the poses of the scene's own cameras."""
    at = np.loadtxt(scene / cameras / "offset.txt").ravel().tolist()
    source = PhotoSource(path=str(scene / "photos"), cameras=str(scene / cameras), offset=tuple(at))
    return {p.id: p for p in read_photos(source, Store(out).world()).photos}


def found_in(out: Path) -> dict[str, Photo]:
    return oriented_photos(out / "orientation", Store(out).world())


def check_poses(scene: Path, out: Path, names: set[str], metres: float, degrees: float) -> None:
    """Poses are near the truth, nearer than the given ones, and their covariances cover what is missing."""
    true, given, found = (
        *(photos_of(scene, out, c) for c in ("cameras", "cameras_approximate")),
        found_in(out),
    )
    assert found.keys() == names
    squared = []
    for name, photo in found.items():
        off = photo.pose.t - true[name].pose.t
        turn = cv2.Rodrigues(photo.pose.R @ true[name].pose.R.T)[0][:, 0]
        assert np.linalg.norm(off) < metres, (name, off)
        assert np.linalg.norm(turn) < np.radians(degrees), (name, np.degrees(turn))
        assert np.linalg.norm(given[name].pose.t - true[name].pose.t) > 0.2
        assert photo.local_from_camera is not None
        error, covariance = np.concatenate([off, turn]), photo.local_from_camera.covariance
        squared.append(float(error @ np.linalg.solve(covariance, error)) / 6)
        assert (photo.local_from_camera.sigma[:3] < 0.02).all()
    assert max(squared) < 9.0 and np.mean(squared) > 0.05, squared


def test_all_photos_are_oriented_to_centimetres(scene: Path, finished: tuple[Path, Summary]) -> None:
    out, summary = finished
    names = {f"IMG_{k:04d}.jpg" for k in (1, 2, 3)}
    check_poses(scene, out, names, 0.025, 0.1)
    assert summary.items["keypoints"] == summary.items["orient"] == 3
    assert summary.items["matches"] == 3
    assert not [w for stage, w in summary.warnings if stage == "orient"]


def test_the_report_has_what_the_design_names(finished: tuple[Path, Summary]) -> None:
    out, _ = finished
    table = report(out)
    assert table["unoriented"] == []
    assert table["source"] in ("intensity", "colour")  # what tells most of the photos
    origin = Store(out).world().origin
    for entry in table["photos"]:
        assert entry.keys() >= KEYS
        pose = np.array(entry["camera_from_world"])
        assert pose.shape == (3, 4)
        assert -pose[:, :3].T @ pose[:, 3] == pytest.approx(entry["center"], abs=1e-6)
        assert np.linalg.norm(entry["center"] - origin) < 200
        assert entry["control_points"] >= 100 and entry["tie_points"] >= 100
        assert 0 < entry["check_rmse"] < 0.02
        assert entry["verdict"] == "confirmed" and 0 < entry["rival"] < 1.0
        covariance = np.array(entry["covariance"])
        assert np.sqrt(np.diag(covariance))[:3] == pytest.approx(entry["sigma_center"])
        assert np.degrees(np.sqrt(np.diag(covariance))[3:]) == pytest.approx(entry["sigma_angles"])
        assert np.linalg.norm(np.subtract(entry["given"], entry["center"])) < 8.0
        residuals = np.array(entry["residuals"])
        assert residuals.shape[1] == 4 and 0 < np.sqrt((residuals[:, 2:] ** 2).mean()) < 3.0
    for name in ("tie points", "control", "surfaces"):
        assert 0.1 < table["factors"][name] < 10
    assert 0.5 < table["sigma0"] < 2.0 and table["redundancy"] > 500 and table["points"] > 100


def test_the_colmap_model_can_be_read_back(finished: tuple[Path, Summary]) -> None:
    out, _ = finished
    folder = out / "orientation" / "colmap"
    model = read_colmap(folder)
    at = np.loadtxt(folder / "offset.txt").ravel() if (folder / "offset.txt").exists() else np.zeros(3)
    world = Store(out).world()
    source = PhotoSource(
        path=str(Store(out).project().photos.path), cameras=str(folder), offset=tuple(at.tolist())
    )
    back = {p.id: p for p in read_photos(source, world).photos}
    found = found_in(out)
    assert back.keys() == found.keys()
    for name, photo in found.items():
        assert back[name].pose.t == pytest.approx(photo.pose.t, abs=1e-6)
        assert rotation_angle(back[name].pose.R @ photo.pose.R.T) < 1e-8
        assert back[name].camera.model == photo.camera.model
        assert back[name].camera.params == pytest.approx(photo.camera.params)
    assert model is not None


def test_the_ortho_images_are_made_with_the_oriented_poses(
    scene: Path, finished: tuple[Path, Summary]
) -> None:
    out, summary = finished
    store = Store(out)
    photos = store.photos()
    assert photos is not None
    found = found_in(out)
    for photo in photos.photos:
        assert np.array_equal(photo.pose.t, found[photo.id].pose.t)
    used = {name for facade in summary.facades for name in store.sidecar(facade).sources}
    assert used & found.keys()


def test_a_second_run_keeps_the_stages(scene: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain, "STAGES", imaging())
    before, told = (out / "orientation" / "report.json").read_bytes(), Told()
    run(project_of(scene), out, progress=told)
    assert all(told.kept[name] for name in ("keypoints", "matches", "orient", "ortho"))
    assert (out / "orientation" / "report.json").read_bytes() == before


def test_key_points_and_matches_come_back_from_their_files(finished: tuple[Path, Summary]) -> None:
    ties = finished[0] / "orientation" / "ties"
    points = [load_key_points(ties / f"keypoints_{k:04d}.npz") for k in range(3)]
    assert all(500 < len(p) <= 2500 and np.isfinite(p.sharpness) for p in points)
    pairs = [pair for k in range(3) for pair in load_matches(ties / f"matches_{k:04d}.npz")]
    assert {(p.first, p.second) for p in pairs} == {(0, 1), (0, 2), (1, 2)}
    assert all(p.rows.max(0)[0] < len(points[p.first]) for p in pairs)
    assert load_matches(ties / "matches_0002.npz") == []  # no photo is later than the last


@pytest.fixture(scope="module")
def disturbed(scene: Path, finished: tuple[Path, Summary], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same photos with a picture of noise and a copy of one of them."""
    folder = tmp_path_factory.mktemp("strangers")
    table = with_strangers(scene, folder)
    with pytest.MonkeyPatch.context() as patch:
        only_orienting(patch)(project_of(scene, **table), folder / "out")
    return folder / "out"


def test_a_foreign_picture_is_named_and_the_rest_stays(
    disturbed: Path, finished: tuple[Path, Summary]
) -> None:
    left = {entry["photo"]: entry for entry in report(disturbed)["unoriented"]}
    assert (
        left["stranger.jpg"]["code"].startswith("O1") and "no other photo" in left["stranger.jpg"]["reason"]
    )
    warned = {w.item: w.message for w in Store(disturbed).manifest().stages["orient"].warnings}
    assert warned.keys() == left.keys()
    assert "stranger.jpg was not oriented" in warned["stranger.jpg"]
    before, after = found_in(finished[0]), found_in(disturbed)
    for name, photo in before.items():
        assert np.linalg.norm(after[name].pose.t - photo.pose.t) < 0.003
        assert rotation_angle(after[name].pose.R @ photo.pose.R.T) < np.radians(0.02)


def test_a_copy_of_a_photo_is_named(disturbed: Path) -> None:
    left = {entry["photo"]: entry["reason"] for entry in report(disturbed)["unoriented"]}
    assert "IMG_0002.jpg" in left["copy.jpg"]


def test_two_photos_without_any_pose_are_enough(
    scene: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    out = pair_run(tmp_path_factory)
    check_poses(scene, out, {"IMG_0002.jpg", "IMG_0003.jpg"}, 0.04, 0.15)
    assert [entry["given"] for entry in report(out)["photos"]] == [None, None]


def test_without_pycolmap_one_sentence_names_the_extra(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pycolmap", None)
    table = some_photos(scene, tmp_path, (2, 3))
    with pytest.raises(MissingExtra, match=r"frontage\[photos\]"):
        run(project_of(scene, **table), tmp_path / "out")


@pytest.mark.parametrize("text", ["", "{", "[]", '{"photos": [{"photo": "a"}]}', '{"photos": 3}', "null"])
def test_a_damaged_report_is_one_sentence(out: Path, text: str) -> None:
    path = out / "orientation" / "report.json"
    path.write_text(text)
    with pytest.raises(FileError) as caught:
        found_in(out)
    sentence = str(caught.value)
    assert "report.json" in sentence and "frontage orient" in sentence and "\n" not in sentence


@pytest.mark.parametrize(("start", "named"), [("", "'orient'"), ("[", "report.json")])
def test_a_damaged_report_stops_a_later_stage_with_one_sentence(out: Path, start: str, named: str) -> None:
    """A file of another size is noticed by its marker, one of the same size when it is read."""
    path = out / "orientation" / "report.json"
    path.write_text(start + path.read_text()[1:])
    with pytest.raises(FrontageError) as caught:
        run_stage(out, "ortho")
    assert named in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["keypoints_0001.npz", "matches_0001.npz"])
def test_damaged_ties_are_one_sentence(out: Path, name: str) -> None:
    path = out / "orientation" / "ties" / name
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(FileError, match="frontage orient"):
        (load_key_points if name.startswith("key") else load_matches)(path)


def test_trusted_photos_have_nothing_to_orient(simulated_run: Path, tmp_path: Path) -> None:
    assert not Store(simulated_run).manifest().stages.keys() & {"keypoints", "matches", "orient"}
    assert not (simulated_run / "orientation").exists()
    with pytest.raises(FrontageError, match="nothing to do for 'orient'"):
        run_stage(Path(shutil.copytree(simulated_run, tmp_path / "copy")), "orient")
