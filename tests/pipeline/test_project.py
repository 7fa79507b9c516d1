"""The project file: what it means, and one clear sentence for what is wrong with it."""

from pathlib import Path

import pytest

from frontage.errors import FileError, FrontageError, OptionError
from frontage.pipeline.project import load_project, make_project

SCAN = '[[scans]]\npath = "a.laz"\n'


def write(folder: Path, text: str) -> Path:
    path = folder / "PROJECT.toml"
    path.write_text(text)
    return path


def test_paths_are_relative_to_the_file_and_globs_are_sorted(tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    for name in ("b.e57", "a.e57", "c.txt"):
        (tmp_path / "scans" / name).touch()
    text = '[[scans]]\npath = "scans/*.e57"\nunits = "ft"\n[photos]\npath = "p/*.jpg"\ncameras = "colmap"\n'
    project = load_project(write(tmp_path, text))
    assert [scan.path for scan in project.scans] == [str(tmp_path / "scans" / n) for n in ("a.e57", "b.e57")]
    assert all(scan.units == "ft" for scan in project.scans)
    assert project.photos is not None and project.photos.cameras == str(tmp_path / "colmap")
    assert project.photos.path == str(tmp_path / "p" / "*.jpg")


def test_offset_txt_beside_the_cameras_is_used_unless_one_is_given(tmp_path: Path) -> None:
    (tmp_path / "colmap").mkdir()
    (tmp_path / "colmap" / "offset.txt").write_text("678000.0 5403000.0 1.5\n")
    photos = '[photos]\npath = "p"\ncameras = "colmap"\n'
    found = load_project(write(tmp_path, SCAN + photos)).photos
    given = load_project(write(tmp_path, SCAN + photos + "offset = [1.0, 2.0, 3.0]\n")).photos
    assert found is not None and found.offset == (678000.0, 5403000.0, 1.5)
    assert given is not None and given.offset == (1.0, 2.0, 3.0)
    (tmp_path / "colmap" / "offset.txt").write_text("678000 north\n")
    with pytest.raises(FileError, match="three numbers"):
        load_project(write(tmp_path, SCAN + photos))


def test_without_scans_the_points_of_the_cameras_are_the_cloud(tmp_path: Path) -> None:
    (tmp_path / "colmap").mkdir()
    (tmp_path / "colmap" / "points3D.txt").write_text("1 0 0 0 1 2 3 0\n")
    table = {"photos": {"path": "p", "cameras": "colmap", "offset": [10.0, 20.0, 0.0]}}
    (scan,) = make_project(table, tmp_path).scans
    assert scan.path == str(tmp_path / "colmap") and scan.offset == (10.0, 20.0, 0.0)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (SCAN + "[ortho]\ngsd = -0.01\n", r"ortho\.gsd = -0\.01 .*greater than 0"),
        (SCAN + "[ortho]\ngds = 0.01\n", r"unknown key 'ortho\.gds'; known there: .*gsd"),
        (SCAN + "speed = 3\n", r"unknown key 'scans\.0\.speed'; known there: crs, offset"),
        (
            SCAN + "[orto]\n",
            r"unknown key 'orto'; known there: .*buildings, .*openings, orientation, ortho, ",
        ),
        (SCAN + '[project]\nseed = "x"\n', r"project\.seed = 'x' is not usable"),
        ("[project]\nseed = 1\n", "no scan is given"),
        ("[[scans]]\nunits = 'm'\n", r"'scans\.0\.path' is missing"),
        ('[scans]\npath = "a"\n', "two brackets"),
        ('[[scans]]\npath = "none/*.laz"\n', r"none/\*\.laz: matches no file"),
        (SCAN + 'pose = "approximate"\n', "there is no city model to register it to"),
        (SCAN + '[orientation]\nsource = "sound"\n', "source = 'sound' is not usable"),
        ("photos = 3\n" + SCAN, r"photos = 3 is not usable"),
        ("[[scans]\n", "is not valid TOML"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises((OptionError, FileError), match=sentence) as caught:
        load_project(write(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_a_missing_project_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(FrontageError, match="no such file"):
        load_project(tmp_path / "PROJECT.toml")
