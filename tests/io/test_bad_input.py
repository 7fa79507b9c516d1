"""Missing, empty, truncated and corrupt files of every format: one clear sentence that names the file."""

import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import CrsError, FileError, InputError
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.colmap import read_colmap
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.npz import load_scan, save_scan
from frontage.io.scans.read import ScanSource, read_scans
from frontage.io.scans.trajectory import read_trajectory
from frontage.model import Scan, WorldRef
from io_files import (
    UTM,
    cloud,
    picture,
    ptx_text,
    whole_files,
    write_colmap_binary,
    write_colmap_text,
    write_e57,
    write_json,
    write_laspy,
    write_photos,
)

SUFFIXES = (".laz", ".las", ".ply", ".e57", ".ptx", ".xyz", ".csv", "points3D.bin", "points3D.txt")
LOCAL = WorldRef(np.zeros(3), None)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return whole_files(tmp_path_factory.mktemp("good"))


def sentence(problem: InputError, path: Path | str) -> str:
    """The message, checked to be one line that names the file and gives advice."""
    text = str(problem)
    assert Path(path).name in text and "\n" not in text and "Traceback" not in text
    assert 20 < len(text) < 600
    return text


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_good_files_are_good(good: dict[str, Path], suffix: str) -> None:
    assert sum(len(s) for s in read_scans(good[suffix])) >= 2


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".npz", ".copc.laz", ".txt"])
def test_missing(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"none{suffix}"
    with pytest.raises(FileError) as e:
        read_scans(path)
    assert "no such file" in sentence(e.value, path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_empty(tmp_path: Path, good: dict[str, Path], suffix: str) -> None:
    path = tmp_path / good[suffix].name
    path.write_bytes(b"")
    with pytest.raises(FileError) as e:
        read_scans(path)
    assert "empty" in sentence(e.value, path)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
@pytest.mark.parametrize("suffix", [".laz", ".las", ".ply", ".e57", ".ptx", "points3D.bin"])
def test_truncated(tmp_path: Path, good: dict[str, Path], suffix: str, share: float) -> None:
    path, data = tmp_path / good[suffix].name, good[suffix].read_bytes()
    path.write_bytes(data[: max(1, int(len(data) * share))])
    with pytest.raises(FileError) as e:
        read_scans(path)
    sentence(e.value, path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_something_else_under_that_name(tmp_path: Path, good: dict[str, Path], suffix: str) -> None:
    path = tmp_path / good[suffix].name
    for data in (
        b"PK\x03\x04 a zip" + bytes(range(256)) * 8,
        b"<html><body>404 not found</body></html>" * 20,
    ):
        path.write_bytes(data)
        with pytest.raises(FileError) as e:
            read_scans(path)
        sentence(e.value, path)


@pytest.mark.parametrize("suffix", [".laz", ".e57"])
def test_flipped_bytes_in_the_middle(tmp_path: Path, good: dict[str, Path], suffix: str) -> None:
    data = bytearray(good[suffix].read_bytes())
    middle = len(data) // 3
    data[middle : middle + 2000] = b"\xff" * min(2000, len(data) - middle)
    path = tmp_path / good[suffix].name
    path.write_bytes(data)
    with pytest.raises(FileError) as e:
        read_scans(path)
    sentence(e.value, path)


HEADS = {
    "a.ply": "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n",  # noqa: E501
    "noxyz.ply": "ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n",
    "open.ply": "ply\nformat ascii 1.0\nelement vertex 1\n",
    "list.ply": "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n1 1\n",
    "type.ply": "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n",
    "a.csv": "x,y,z\n",
    "two.xyz": "1 2\n3 4\n",
    "ragged.xyz": "1 2 3\n4 5\n6 7 8\n",
    "names.csv": "a,b,c,d,e\n1,2,3,4,5\n",
    "nan.xyz": "nan nan nan\nnan nan nan\n",
    "inf.xyz": "inf 1 2\n1 -inf 2\n",
    "head.ptx": "4\n3\n0 0 0\n",
    "huge.ptx": "400000\n3000000\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
    "none.ptx": "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0 0 0 0.5\n0 0 0 0.5\n",  # noqa: E501
    "mirror.ptx": ptx_text().replace("0.000000 0.000000 1.000000 0.000000", "0 0 -1 0"),
    "words.ptx": ptx_text().replace("2 3 1.5", "two 3 1.5"),
    "points3D.txt": "# nothing\n",
    "scan.docx": "not a scan\n",
    "noending": "1 2 3\n",
}


@pytest.mark.parametrize("name", HEADS)
def test_wrong_content(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(HEADS[name])
    with pytest.raises(FileError) as e:
        read_scans(path)
    sentence(e.value, path)


def test_las_without_points_and_a_folder(tmp_path: Path) -> None:
    import laspy

    laspy.LasData(laspy.LasHeader(point_format=3)).write(tmp_path / "zero.las")
    with pytest.raises(FileError, match="no points"):
        read_scans(tmp_path / "zero.las")
    with pytest.raises(FileError, match="COLMAP"):
        read_scans(tmp_path)


def test_points_that_are_not_finite_are_dropped_with_a_note(tmp_path: Path) -> None:
    (tmp_path / "n.xyz").write_text("1 2 3\nnan 2 3\n4 5 inf\n7 8 9\n")
    scan = read_scans(tmp_path / "n.xyz")[0]
    np.testing.assert_allclose(scan.xyz, [[1, 2, 3], [7, 8, 9]])
    assert any("2 points without finite" in n for n in scan.notes)


def test_wrong_crs_names(tmp_path: Path, good: dict[str, Path]) -> None:
    for crs in ("EPSG:999999", "somewhere", "EPSG:"):
        with pytest.raises(CrsError) as e:
            read_scans(ScanSource(path=str(good[".xyz"]), crs=crs))
        assert crs in str(e.value) and "EPSG:25832" in str(e.value)
    with pytest.raises(CrsError, match="projected"):
        read_scans(good[".laz"], target_crs="EPSG:4326")


def test_mixed_crs(tmp_path: Path, good: dict[str, Path]) -> None:
    with pytest.raises(CrsError, match="has no CRS, but"):
        read_scans(good[".ptx"], UTM)
    with pytest.raises(CrsError, match="other data has no CRS"):
        read_scans(good[".laz"], LOCAL)


def test_coordinates_that_do_not_fit_their_crs(tmp_path: Path) -> None:
    path = write_laspy(
        tmp_path / "far.las", np.array([[5e8, 5e8, 1.0], [5e8, 6e8, 2.0]]) / 1e3 + 1e9, crs="EPSG:25833"
    )
    with pytest.raises(CrsError):
        read_scans(path, WorldRef(np.zeros(3), "EPSG:25832"))


STATIONS = ["{", "[]", "[{}]", '[{"station": 1, "position": [1, 2]}]', '[{"station": "a", "position": [1, 2, 3]}]',  # noqa: E501
            '[{"station": 1, "position": [1, 2, 3]}, {"station": 1, "position": [1, 2, 3]}]']  # fmt: skip


@pytest.mark.parametrize("text", STATIONS)
def test_bad_stations(tmp_path: Path, text: str) -> None:
    path = write_laspy(tmp_path / "s.las", np.random.default_rng(0).uniform(0, 9, (9, 3)), 6)
    (tmp_path / "s.las.stations.json").write_text(text)
    with pytest.raises(FileError) as e:
        read_scans(path)
    sentence(e.value, "s.las.stations.json")


TRACKS = [
    "",
    "1 2 3\n",
    "gps_time,x,y\n1,2,3\n",
    "gps_time,x,y,z\n",
    "gps_time,x,y,z\n1,2,3,4\n",
    "gps_time,x,y,z\n1,2,a,4\n",
]


@pytest.mark.parametrize("text", TRACKS)
def test_bad_trajectories(tmp_path: Path, text: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(FileError) as e:
        read_trajectory(path)
    sentence(e.value, path)


def test_trajectory_of_another_day_and_points_without_time(tmp_path: Path, good: dict[str, Path]) -> None:
    path = tmp_path / "t.csv"
    path.write_text("gps_time,x,y,z\n500,1,2,3\n510,1,2,3\n")
    with pytest.raises(FileError, match="do not overlap"):
        read_scans(ScanSource(path=str(good[".laz"]), trajectory=str(path)))
    timeless = write_laspy(tmp_path / "n.las", np.random.default_rng(0).uniform(0, 9, (9, 3)), 2)
    with pytest.raises(FileError, match="no gps_time"):
        read_scans(ScanSource(path=str(timeless), trajectory=str(path)))
    (tmp_path / "t.sbet").write_bytes(b"\0" * 200)
    with pytest.raises(FileError, match="SBET"):
        read_trajectory(tmp_path / "t.sbet")


def picture_bomb() -> bytes:
    """A complete PNG of one row that claims to be gigantic."""
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", 40_000, 40_000, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"\0")),
    ]
    body = b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in [*chunks, (b"IEND", b"")]
    )
    return b"\x89PNG\r\n\x1a\n" + body


def photos(folder: Path, model: Path) -> PhotoSource:
    return PhotoSource(path=str(folder), cameras=str(model))


def spoil(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


MODELS: dict[str, tuple[Callable[[Path, Path], object], str]] = {
    "no model": (lambda m, p: [f.unlink() for f in m.iterdir()], "no COLMAP model"),
    "no images": (lambda m, p: (m / "images.txt").unlink(), "no such file"),
    "camera model": (lambda m, p: spoil(m / "cameras.txt", "PINHOLE", "LOMO"), "COLMAP cameras"),
    "camera params": (lambda m, p: spoil(m / "cameras.txt", "30 20", ""), "COLMAP cameras"),
    "absent camera": (lambda m, p: spoil(m / "images.txt", "7 a.jpg", "8 a.jpg"), "uses camera 8"),
    "short image line": (lambda m, p: spoil(m / "images.txt", "0 7 a.jpg", ""), "COLMAP images"),
    "zero quaternion": (lambda m, p: spoil(m / "images.txt", "3 1 0 0 0", "3 0 0 0 0"), "COLMAP images"),
    "absent photo": (lambda m, p: (p / "a.jpg").unlink(), "not there: a.jpg"),
    "no photos": (lambda m, p: [f.unlink() for f in p.rglob("*.jpg")], "no photos"),
    "size": (lambda m, p: (p / "a.jpg").write_bytes(picture(30, 20)), "30 x 20 px but its camera is 60 x 40"),
    "turned, no EXIF": (lambda m, p: (p / "a.jpg").write_bytes(picture(40, 60)), "40 x 60 px"),
    "not a picture": (lambda m, p: (p / "a.jpg").write_bytes(b"hello" * 99), "picture"),
    "truncated": (lambda m, p: (p / "a.jpg").write_bytes(picture()[:-200]), "truncated"),
    "header only": (lambda m, p: (p / "a.jpg").write_bytes(picture()[:30]), "not a readable picture"),
    "bomb": (lambda m, p: (p / "a.jpg").write_bytes(picture_bomb()), "claims 40000 x 40000 px"),
    "empty": (lambda m, p: (p / "a.jpg").write_bytes(b""), "empty"),
}


@pytest.mark.parametrize("case", MODELS)
def test_bad_models_and_photos(tmp_path: Path, case: str) -> None:
    model, pictures = write_colmap_text(tmp_path / "model"), write_photos(tmp_path / "pictures")
    assert len(read_photos(photos(pictures, model), LOCAL).photos) == 2
    change, message = MODELS[case]
    change(model, pictures)
    with pytest.raises(FileError) as e:
        read_photos(photos(pictures, model), LOCAL)
    assert message in str(e.value) and "\n" not in str(e.value)


@pytest.mark.parametrize("name", ["cameras.bin", "images.bin"])
@pytest.mark.parametrize("keep", [5, 30, -3])
def test_truncated_binary_models(tmp_path: Path, name: str, keep: int) -> None:
    model = write_colmap_binary(tmp_path)
    (model / name).write_bytes((model / name).read_bytes()[:keep])
    with pytest.raises(FileError) as e:
        read_colmap(model)
    sentence(e.value, name)


def test_photos_that_are_deleted_later_and_photos_without_cameras(tmp_path: Path) -> None:
    model, pictures = write_colmap_text(tmp_path / "model"), write_photos(tmp_path / "pictures")
    found = read_photos(photos(pictures, model), LOCAL)
    (pictures / "a.jpg").unlink()
    with pytest.raises(FileError, match="no such file"):
        found.image("a.jpg")
    with pytest.raises(InputError, match="cameras"):
        read_photos(PhotoSource(path=str(pictures)), LOCAL)


FOOTPRINTS = {
    "a.json": "{",
    "b.json": '{"type": "Something"}',
    "c.json": '{"type": "CityJSON", "version": "2.0", "CityObjects": {}, "vertices": []}',
    "d.geojson": '{"type": "FeatureCollection", "features": []}',
    "e.json": '{"type": "CityJSON", "CityObjects": {"a": {"type": "Building", "geometry": [{"type": "MultiSurface",'  # noqa: E501
    ' "lod": "1", "boundaries": [[[0, 1, 9]]]}]}}, "vertices": [[0, 0, 0]]}',
    "f.gml": "<CityModel>",
    "g.gml": "<html><body/></html>",
    "h.gml": '<!DOCTYPE CityModel [<!ENTITY x SYSTEM "file:///etc/passwd">]><CityModel>&x;</CityModel>',
    "i.gml": "<CityModel/>",
    "j.txt": "1 2 3",
    "k.gml": "<CityModel><Building id='a'><exterior><posList>1 2 3 4</posList></exterior></Building></CityModel>",  # noqa: E501
}


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_bad_footprints(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(FOOTPRINTS[name])
    with pytest.raises(FileError) as e:
        read_footprints(tmp_path / name, LOCAL)
    sentence(e.value, name)


def test_footprints_of_another_world(tmp_path: Path) -> None:
    ring = [[11.4, 48.7], [11.41, 48.7], [11.41, 48.71], [11.4, 48.7]]
    path = write_json(
        tmp_path / "m.geojson", {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [ring]}}
    )
    assert len(read_footprints(path, UTM)) == 1
    with pytest.raises(CrsError, match="other data has no CRS"):
        read_footprints(path, LOCAL)


@pytest.mark.parametrize("keep", [0, 100, 0.5])
def test_damaged_intermediates(tmp_path: Path, keep: float) -> None:
    path = save_scan(tmp_path / "s.npz", cloud())
    data = path.read_bytes()
    path.write_bytes(data[: int(keep * len(data)) if keep < 1 else int(keep)])
    with pytest.raises(FileError) as e:
        load_scan(path)
    sentence(e.value, path)


def test_nothing_pickled_is_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "p.npz", meta=np.array([{"a": 1}], object), xyz=np.zeros((1, 3)), origin=np.zeros(3))
    with pytest.raises(FileError):
        load_scan(tmp_path / "p.npz")


def test_a_failed_write_leaves_the_earlier_file(tmp_path: Path) -> None:
    from frontage.io.scans.laswrite import write_las

    path = write_las(tmp_path / "a.laz", cloud())
    before = path.read_bytes()
    with pytest.raises(FileError, match="400 km"):
        write_las(path, Scan("far", np.array([[0.0, 0, 0], [1e6, 0, 0]]), UTM))
    assert path.read_bytes() == before and [p.name for p in tmp_path.glob(".*")] == []


def test_e57_without_any_return_is_refused(tmp_path: Path) -> None:
    gone = np.full(240, 2)
    gone[0] = 0
    path = write_e57(tmp_path / "one.e57", 1, cartesianInvalidState=gone)
    assert len(read_scans(path)[0]) == 1
