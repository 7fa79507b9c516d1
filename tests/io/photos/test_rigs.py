"""Rigs are read from COLMAP, OpenSfM and COLMAP's rig_config.json; all say the same of one vehicle."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from frontage.errors import FrontageError
from frontage.geometry.rigid import Rigid3, quaternion_from_rotation
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, photo_inputs, read_photos
from frontage.model import Rig, WorldRef
from io_files import picture

WORLD = WorldRef(np.zeros(3, np.int64))
LEFT = Rigid3("body", "camera", Rotation.from_euler("y", 40, degrees=True).as_matrix(), [0.1, -0.2, 0.3])
IDENTITY = Rigid3.identity("body", "camera")
BODIES = [
    Rigid3("world", "body", Rotation.from_rotvec([0.1, 1.2, 0.02 * k]).as_matrix(), [2.0 * k, 1.0, 0.5])
    for k in range(2)
]
FIRST = "1 PINHOLE 60 40 50 50 30 20\n2 PINHOLE 60 40 55 55 30 20\n3 PINHOLE 60 40 60 60 30 20\n"


def folder_of(path: Path) -> Path:
    """Photos of two cameras at two moments, and one of a third camera on its own."""
    for name in ("front/0.jpg", "front/1.jpg", "left/0.jpg", "left/1.jpg", "hand.jpg"):
        file = path / "photos" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(picture())
    return path


def words(pose: Rigid3) -> list[float]:
    return [*quaternion_from_rotation(pose.R).tolist(), *pose.t.tolist()]


def joined(values: list[float]) -> str:
    return " ".join(repr(v) for v in values)


def views() -> list[tuple[int, str, Rigid3]]:
    """Camera, name and camera_from_world of all five photos."""
    posed = [(1, f"front/{k}.jpg", body.inverse) for k, body in enumerate(BODIES)]
    posed += [(2, f"left/{k}.jpg", body.after(LEFT).inverse) for k, body in enumerate(BODIES)]
    return [*posed, (3, "hand.jpg", BODIES[0].inverse)]


def colmap(path: Path, binary: bool = False, known: bool = True) -> Path:
    """A COLMAP model whose cameras 1 and 2 are a rig, and camera 3 is one on its own."""
    model = path / "model"
    model.mkdir()
    (model / "cameras.txt").write_text(FIRST)
    (model / "points3D.txt").write_text("# no points\n")
    lines = [
        f"{n} {joined(words(pose))} {camera} {name}\n\n" for n, (camera, name, pose) in enumerate(views(), 1)
    ]
    (model / "images.txt").write_text("".join(lines))
    frames = [(1, 1, [(1, 1), (2, 3)]), (2, 1, [(1, 2), (2, 4)]), (3, 2, [(3, 5)])]
    from_rig = words(LEFT.inverse)
    if binary:
        state = struct.pack("<iIB", 0, 2, known) + (struct.pack("<7d", *from_rig) if known else b"")
        rigs = struct.pack("<QIIiI", 2, 1, 2, 0, 1) + state + struct.pack("<IIiI", 2, 1, 0, 3)
        (model / "rigs.bin").write_bytes(rigs)
        data = struct.pack("<Q", len(frames))
        for frame, rig, images in frames:
            data += struct.pack("<II7dI", frame, rig, 1, 0, 0, 0, 0, 0, 0, len(images))
            data += b"".join(struct.pack("<iIQ", 0, camera, image) for camera, image in images)
        (model / "frames.bin").write_bytes(data)
        return model
    state_text = f"1 {joined(from_rig)}" if known else "0"
    (model / "rigs.txt").write_text(f"# Rigs\n1 2 CAMERA 1 CAMERA 2 {state_text}\n2 1 CAMERA 3\n")
    rows = [
        f"{frame} {rig} 1 0 0 0 0 0 0 {len(images)} " + " ".join(f"CAMERA {c} {i}" for c, i in images)
        for frame, rig, images in frames
    ]
    (model / "frames.txt").write_text("# Frames\n" + "\n".join(rows) + "\n")
    return model


def opensfm(path: Path, beside: str | None = None) -> Path:
    """A reconstruction with a rig, or with one stated `beside` it in "new" or "old" files."""

    def about(pose: Rigid3) -> dict[str, Any]:
        return {"rotation": Rotation.from_matrix(pose.R).as_rotvec().tolist(), "translation": pose.t.tolist()}

    cameras = {"front": about(IDENTITY), "left": about(LEFT.inverse)}
    instances: dict[str, Any] = {
        f"{k}": {
            **about(body.inverse),
            "rig_camera_ids": {f"front/{k}.jpg": "front", f"left/{k}.jpg": "left"},
        }
        for k, body in enumerate(BODIES)
    }
    single = {**about(BODIES[0].inverse), "rig_camera_ids": {"hand.jpg": "hand"}}
    lens = {"projection_type": "perspective", "width": 60, "height": 40, "focal": 1.0}
    part: dict[str, Any] = {
        "cameras": {"c": lens},
        "shots": {name: {"camera": "c", **about(pose)} for _, name, pose in views()},
    }
    if beside is None:
        part["rig_cameras"] = {**cameras, "hand": about(IDENTITY)}
        part["rig_instances"] = {**instances, "single": single}
        for shot in part["shots"].values():
            del shot["rotation"], shot["translation"]  # only the rig tells the pose
    else:
        (path / "rig_cameras.json").write_text(json.dumps(cameras))
        rows = [[[f"{c}/{k}.jpg", c] for c in ("front", "left")] for k in range(2)]
        named: Any = rows if beside == "old" else {str(k): row for k, row in enumerate(rows)}
        (path / "rig_assignments.json").write_text(json.dumps(named))
    file = path / "reconstruction.json"
    file.write_text(json.dumps([part]))
    return file


def rig_file(path: Path, **of_left: Any) -> Path:
    """The rig in COLMAP's own words."""
    pose = words(LEFT.inverse)
    left = {"image_prefix": "left/", "cam_from_rig_rotation": pose[:4], "cam_from_rig_translation": pose[4:]}
    front = {"image_prefix": "front/", "ref_sensor": True}
    left = {key: value for key, value in {**left, **of_left}.items() if value is not None}
    file = path / "rig.json"
    file.write_text(json.dumps([{"cameras": [front, left]}]))
    return file


def read(path: Path, cameras: Path | None, pose: Any = "approximate", **more: Any) -> PhotoSet:
    source = PhotoSource(path=str(path / "photos"), cameras=cameras and str(cameras), pose=pose, **more)
    return read_photos(source, WORLD)


def check(found: PhotoSet, known: bool = True) -> Rig:
    """The rig is the vehicle of this module, and the relative poses are those of the photos."""
    (rig,) = found.rigs
    assert sorted(e.photos for e in rig.exposures) == [(f"front/{k}.jpg", f"left/{k}.jpg") for k in range(2)]
    assert all(e.cameras == (0, 1) for e in rig.exposures)
    front, left = (camera.body_from_camera for camera in rig.cameras)
    assert front is not None and np.allclose(front.value.matrix, np.eye(4))
    assert (left is not None) == known
    if left is not None:
        assert np.allclose(left.value.matrix, LEFT.matrix, atol=1e-9)
        pose = {p.id: p.pose for p in found.photos if p.local_from_camera is not None}
        for name in (k for k in pose if k.startswith("left")):
            relative = pose[name.replace("left", "front")].inverse.after(pose[name])
            assert np.allclose(relative.matrix, left.value.matrix, atol=1e-9)
    return rig


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("known", [False, True])
def test_rigs_of_colmap(tmp_path: Path, binary: bool, known: bool) -> None:
    model = colmap(folder_of(tmp_path), binary, known)
    rig = check(read(tmp_path, model), known)
    assert [c.name for c in rig.cameras] == ["camera 1", "camera 2"]
    names = {f.name for f in photo_inputs(PhotoSource(path=str(tmp_path / "photos"), cameras=str(model)))}
    assert {"rigs.bin", "frames.bin"} <= names if binary else {"rigs.txt", "frames.txt"} <= names


def test_a_rig_that_pycolmap_wrote_is_read(tmp_path: Path) -> None:
    pycolmap = pytest.importorskip("pycolmap")
    model = pycolmap.Reconstruction(colmap(folder_of(tmp_path)))
    for kind, write in (("text", model.write_text), ("binary", model.write_binary)):
        (tmp_path / kind).mkdir()
        write(tmp_path / kind)
        check(read(tmp_path, tmp_path / kind))


def test_a_model_without_rigs_has_none(tmp_path: Path) -> None:
    model = colmap(folder_of(tmp_path))
    (model / "frames.txt").unlink()
    assert read(tmp_path, model).rigs == ()


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("rigs.txt", "2 1 CAMERA 3", "2 1 CAMERA 3 7", "more words"),
        ("rigs.txt", "CAMERA 2", "LIDAR 2", "LIDAR"),
        ("frames.txt", "1 1 1 0", "1 9 1 0", "frame 1 has a rig or a camera that is not there"),
        ("frames.txt", "CAMERA 2 3", "CAMERA 2", "frame 1 has 5 words for 2 images"),
        ("frames.txt", "CAMERA 2 3", "CAMERA 2 2", "photo front/1.jpg was taken twice"),
    ],
)
def test_damaged_rigs_of_colmap_are_refused(
    tmp_path: Path, name: str, old: str, new: str, message: str
) -> None:
    file = colmap(folder_of(tmp_path)) / name
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(FrontageError, match=message):
        read(tmp_path, file.parent)


@pytest.mark.parametrize("name", ["rigs.bin", "frames.bin"])
@pytest.mark.parametrize("cut", [4, 20, 3])
def test_truncated_rigs_of_colmap_are_refused(tmp_path: Path, name: str, cut: int) -> None:
    file = colmap(folder_of(tmp_path), binary=True) / name
    data = file.read_bytes()
    file.write_bytes(data[: len(data) - 4] if cut == 3 else data[:cut])
    with pytest.raises(FrontageError, match=name):
        read(tmp_path, file.parent)


@pytest.mark.parametrize("beside", [None, "new", "old"])
def test_rigs_of_opensfm(tmp_path: Path, beside: str | None) -> None:
    file = opensfm(folder_of(tmp_path), beside)
    rig = check(read(tmp_path, file))
    assert [c.name for c in rig.cameras] == ["front", "left"]
    if beside:
        (tmp_path / "rig_assignments.json").write_text('{"0": [["front/0.jpg", "roof"]]}')
        with pytest.raises(FrontageError, match="'roof'"):
            read(tmp_path, file)


def test_a_rig_file_joins_photos_by_their_folders(tmp_path: Path) -> None:
    stated = rig_file(folder_of(tmp_path))
    found = read(tmp_path, None, "none", rig=str(stated))
    assert sorted(p.id for p in found.photos)[:2] == ["front/0.jpg", "front/1.jpg"]
    rig = check(found)
    assert [c.name for c in rig.cameras] == ["front", "left"] and [e.name for e in rig.exposures] == [
        "0",
        "1",
    ]
    assert any("1 photos belong to no camera" in note for note in found.notes)
    assert stated in photo_inputs(PhotoSource(path=str(tmp_path / "photos"), pose="none", rig=str(stated)))


def test_photos_of_one_folder_are_told_apart_by_their_names(tmp_path: Path) -> None:
    for name in ("front_0.jpg", "front_1.jpg", "front_left_0.jpg", "front_left_1.png"):
        (tmp_path / "photos").mkdir(exist_ok=True)
        (tmp_path / "photos" / name).write_bytes(picture())
    stated = rig_file(tmp_path, image_prefix="front_left_")
    stated.write_text(stated.read_text().replace("front/", "front_"))
    (rig,) = read(tmp_path, None, "none", rig=str(stated)).rigs
    assert [e.photos for e in rig.exposures] == [
        ("front_0.jpg", "front_left_0.jpg"),
        ("front_1.jpg", "front_left_1.png"),
    ]


def test_standard_errors_of_relative_poses(tmp_path: Path) -> None:
    own = rig_file(folder_of(tmp_path), sigma_position=0.01, sigma_angle=0.5)
    (rig,) = read(tmp_path, None, "none", rig=str(own), rig_sigma_position=1.0).rigs
    front, left = (c.body_from_camera for c in rig.cameras)
    assert front is not None and (front.sigma == 0).all()
    assert left is not None and left.sigma == pytest.approx([0.01] * 3 + [np.radians(0.5)] * 3)
    (rig,) = read(tmp_path, colmap(tmp_path), rig_sigma_position=0.02, rig_sigma_angle=0.1).rigs
    front, left = (c.body_from_camera for c in rig.cameras)
    assert front is not None and (front.sigma == 0).all()
    assert left is not None and left.sigma == pytest.approx([0.02] * 3 + [np.radians(0.1)] * 3)


def test_calibrations_of_a_rig_file_replace_those_from_exif_only(tmp_path: Path) -> None:
    stated = rig_file(folder_of(tmp_path), camera_model_name="PINHOLE", camera_params=[70, 71, 30, 20])
    found = read(tmp_path, None, "none", rig=str(stated))
    camera = {p.id: p.camera for p in found.photos}
    assert (
        camera["left/0.jpg"].params.tolist() == [70, 71, 30, 20] and camera["front/0.jpg"].model == "OPENCV"
    )
    assert (found.camera_sigmas["left/0.jpg"] == 0).all() and (found.camera_sigmas["front/0.jpg"] > 0).all()
    found = read(tmp_path, colmap(tmp_path), rig=str(stated))
    assert {p.camera.params[0] for p in found.photos} == {50, 55, 60}
    assert any("calibrations are not used" in n for n in found.notes)
    assert any("replace those of the file with the cameras" in n for n in found.notes)


def test_a_camera_without_a_relative_pose_is_unknown(tmp_path: Path) -> None:
    stated = rig_file(folder_of(tmp_path), cam_from_rig_rotation=None, cam_from_rig_translation=None)
    check(read(tmp_path, None, "none", rig=str(stated)), known=False)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"image_prefix": "right/", "ref_sensor": True}, "reference, and has no relative pose"),
        (
            {"ref_sensor": True, "cam_from_rig_rotation": None, "cam_from_rig_translation": None},
            "needs one camera",
        ),
        ({"cam_from_rig_rotation": None}, "half a relative pose"),
        ({"cam_from_rig_rotation": [0, 0, 0, 0]}, "is zero"),
        ({"cam_from_rig_translation": [0, 0]}, "has not 3 numbers"),
        ({"cam_from_rig_translaton": [0, 0, 0]}, "unknown key 'cam_from_rig_translaton'"),
        ({"image_prefix": "front/"}, "same image_prefix"),
        ({"image_prefix": ""}, "empty image_prefix"),
        ({"sigma_position": -1}, "negative"),
        ({"camera_model_name": "PINHOLE"}, "camera_params"),
        ({"camera_model_name": "PINHOLE", "camera_params": [1]}, "PINHOLE"),
        ({"image_prefix": "fro"}, "took two photos"),
    ],
)
def test_a_rig_file_with_an_error_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    stated = rig_file(folder_of(tmp_path), **changes)
    if message == "took two photos":
        (tmp_path / "photos" / "fron0.jpg").write_bytes(picture())
        (tmp_path / "photos" / "fron0.png").write_bytes(picture())
    with pytest.raises(FrontageError, match=message):
        read(tmp_path, None, "none", rig=str(stated))


def test_a_rig_file_of_other_photos_is_refused(tmp_path: Path) -> None:
    stated = rig_file(folder_of(tmp_path), image_prefix="back/")
    stated.write_text(stated.read_text().replace("front/", "roof/"))
    with pytest.raises(FrontageError, match="none of the photos has a name"):
        read(tmp_path, None, "none", rig=str(stated))
    stated.write_text("[]")
    with pytest.raises(FrontageError, match="no list of rigs"):
        read(tmp_path, None, "none", rig=str(stated))
