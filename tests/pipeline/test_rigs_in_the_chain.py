"""A simulated vehicle with three cameras, one of which sees only sky, is oriented by the whole chain."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3, quaternion_from_rotation, rotation_angle
from frontage.io.colmap import read_colmap
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.photos.write import write_poses
from frontage.pipeline.store.orientation import oriented_photos
from frontage.pipeline.store.store import Store
from frontage.report.orientation import orientation_facts
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate
from orientation.orientedscene import SPEC, only_orienting, project_of

pytest.importorskip("pycolmap")

STOPS = (5.0, 8.5)
CAMERAS = {
    "front": (0.0, 0.0, 0.0, -8.0, 12.0),
    "side": (0.6, -0.3, 0.2, 22.0, 14.0),
    "sky": (0.3, 0.1, 0.5, 0, 78),
}
"""Along, across and above the first camera (m), heading and pitch (degrees)."""


def made(folder: Path) -> Path:
    """The scene, with its photos in a folder per camera and the file of the rig."""
    head = SPEC[: SPEC.index("[[cameras.places]]")].replace("slope = 1.0", "slope = 0.0")
    head = head.replace("1120", "800").replace("840", "600").replace("stations = 2", "stations = 1")
    spec = head.replace("cars = 1", "cars = 0")
    for stop in STOPS:
        for x, y, z, heading, pitch in CAMERAS.values():
            spec += (
                f"[[cameras.places]]\nalong = {stop + x}\nacross = {y - 12.3}\nheight = {z + 1.8}\n"
                f"heading = {heading}\npitch = {pitch}\n"
            )
    scene = simulate(parse_spec(spec + "[output]\ngsd = 0.05\n"), folder / "scene").out
    names = [f"{camera}/{k}.jpg" for k in range(len(STOPS)) for camera in CAMERAS]
    listings = [scene / name / "images.txt" for name in ("cameras", "cameras_approximate")]
    for number, name in enumerate(names, 1):
        (scene / "photos" / name).parent.mkdir(exist_ok=True)
        shutil.move(scene / "photos" / f"IMG_{number:04d}.jpg", scene / "photos" / name)
        for listing in listings:
            listing.write_text(listing.read_text().replace(f"IMG_{number:04d}.jpg", name))
    (scene / "rig.json").write_text(json.dumps([{"name": "car", "cameras": [*rig_cameras(scene)]}]))
    return scene


def rig_cameras(scene: Path) -> list[dict[str, Any]]:
    pose = {i.name: i.camera_from_world for i in read_colmap(scene / "cameras").images}
    stated: list[dict[str, Any]] = [{"image_prefix": "front/", "ref_sensor": True}]
    for camera in ("side", "sky"):
        first, second = (pose[f"{camera}/{k}.jpg"].after(pose[f"front/{k}.jpg"].inverse) for k in (0, 1))
        assert np.allclose(first.matrix, second.matrix, atol=1e-9)  # the vehicle is rigid
        stated.append(
            {
                "image_prefix": f"{camera}/",
                "cam_from_rig_rotation": quaternion_from_rotation(first.R).tolist(),
                "cam_from_rig_translation": first.t.tolist(),
            }
        )
    return stated


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The folders of the scene and of the run."""
    base = tmp_path_factory.mktemp("rigs")
    scene = made(base)
    with pytest.MonkeyPatch.context() as patch:
        only_orienting(patch)(
            project_of(scene, path=str(scene / "photos"), rig=str(scene / "rig.json")), base / "out"
        )
    return scene, base / "out"


def report(out: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads((out / "orientation" / "report.json").read_text())
    return table


def true_poses(scene: Path, out: Path) -> dict[str, Rigid3]:
    at = np.loadtxt(scene / "cameras" / "offset.txt").ravel().tolist()
    source = PhotoSource(path=str(scene / "photos"), cameras=str(scene / "cameras"), offset=tuple(at))
    return {p.id: p.pose for p in read_photos(source, Store(out).world()).photos}


def test_all_photos_of_the_vehicle_are_oriented(run: tuple[Path, Path]) -> None:
    scene, out = run
    true, found = true_poses(scene, out), oriented_photos(out / "orientation", Store(out).world())
    assert found.keys() == true.keys() and len(found) == 6 and not report(out)["unoriented"]
    for name, photo in found.items():
        off = photo.pose.t - true[name].t
        turn = rotation_angle(photo.pose.R @ true[name].R.T)
        assert np.linalg.norm(off) < 0.05 and turn < np.radians(0.2), (name, off, np.degrees(turn))
        assert photo.local_from_camera is not None
        assert np.linalg.norm(off) < 4.0 * np.linalg.norm(photo.local_from_camera.sigma[:3])


def test_the_relative_poses_are_kept(run: tuple[Path, Path]) -> None:
    scene, out = run
    true, found = true_poses(scene, out), oriented_photos(out / "orientation", Store(out).world())
    for camera in ("side", "sky"):
        for k in (0, 1):
            names = f"front/{k}.jpg", f"{camera}/{k}.jpg"
            off = [poses[names[0]].inverse.after(poses[names[1]]).matrix for poses in
                   (true, {n: p.pose for n, p in found.items()})]  # fmt: skip
            assert np.allclose(*off, atol=1e-7)


def test_the_report_names_the_rig_and_what_only_it_orients(run: tuple[Path, Path]) -> None:
    table = report(run[1])
    entries = {p["photo"]: p for p in table["photos"]}
    for k in (0, 1):
        sky = entries[f"sky/{k}.jpg"]
        assert sky["verdict"] == "carried" and sky["control_points"] == sky["tie_points"] == 0
        assert {entries[f"{camera}/{k}.jpg"]["exposure"] for camera in CAMERAS} == {str(k)}
        assert entries[f"front/{k}.jpg"]["verdict"] == "confirmed"
    assert {p["rig"] for p in entries.values()} == {"car"}
    (rig,) = table["rigs"]
    assert [c["camera"] for c in rig["cameras"]] == list(CAMERAS)
    assert not any(c["estimated"] for c in rig["cameras"])
    assert rig["exposures"][1]["photos"] == {camera: f"{camera}/1.jpg" for camera in CAMERAS}
    assert any("sky/0.jpg, sky/1.jpg" in note for note in table["notes"])
    assert any(fact.name == "Rig: car" for fact in orientation_facts(table))


def test_oriented_photos_of_a_rig_are_exported(run: tuple[Path, Path], tmp_path: Path) -> None:
    scene, out = run
    model = {i.name: i for i in read_colmap(out / "orientation" / "colmap").images}
    found = oriented_photos(out / "orientation", Store(out).world())
    assert model.keys() == found.keys()
    for name, photo in found.items():
        assert np.allclose(model[name].camera_from_world.inverse.t, photo.pose.t, atol=1e-6)
    world = replace(Store(out).world(), crs=None)
    for kind, file in (("opensfm", "reconstruction.json"), ("metashape", "cameras.xml")):
        written = write_poses(tmp_path / file, list(found.values()), world, kind)
        source = PhotoSource(path=str(scene / "photos"), cameras=str(written))
        again = {p.id: p.pose for p in read_photos(source, world).photos}
        assert np.allclose(again["sky/1.jpg"].t, found["sky/1.jpg"].pose.t, atol=1e-4)
