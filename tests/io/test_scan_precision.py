"""What stored coordinates can resolve is measured on reading: told above 1 mm, refused from 5 cm on."""

from pathlib import Path

import numpy as np
import pytest

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.io.scans.e57write import write_e57 as write_own_e57
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import Scan
from io_files import UTM, ptx_text, write_laspy

FORMATS = ("xyz", "csv", "ply", "las", "laz", "e57")


def points(corner: tuple[float, float, float], size: float = 30.0) -> Float:
    return np.random.default_rng(0).uniform(0, size, (3000, 3)) + corner


def write(folder: Path, kind: str, xyz: Float, real: str = "double") -> Path:
    path = folder / f"a.{kind}"
    if kind in ("las", "laz"):
        return write_laspy(path, xyz)
    if kind == "e57":
        import pye57

        with pye57.E57(str(path), mode="w") as e57:
            e57.write_scan_raw({f"cartesian{a}": xyz[:, k] for k, a in enumerate("XYZ")})
        return path
    if kind == "ply":
        head = "".join(f"property {real} {a}\n" for a in "xyz")
        rows = xyz.astype("<f8" if real == "double" else "<f4").tobytes()
        text = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(xyz)}\n{head}end_header\n"
        path.write_bytes(text.encode() + rows)
        return path
    np.savetxt(path, xyz, "%.3f", delimiter="," if kind == "csv" else " ")
    return path


WORLD = (678_000.0, 5_403_000.0, 400.0)


@pytest.mark.parametrize("kind", FORMATS)
def test_floats_of_32_bits_at_world_size_are_refused(tmp_path: Path, kind: str) -> None:
    coarse = points(WORLD).astype(np.float32).astype(np.float64)
    with pytest.raises(FileError, match=r"steps of 0.5 m") as e:
        read_scans(write(tmp_path, kind, coarse))
    assert e.value.code == "I116" and "offset" in str(e.value) and f"a.{kind}" in str(e.value)


@pytest.mark.parametrize("kind", FORMATS)
def test_coarse_steps_are_told(tmp_path: Path, kind: str) -> None:
    coarse = points((40_000.0, 50_000.0, 400.0)).astype(np.float32).astype(np.float64)
    notes = read_scans(write(tmp_path, kind, coarse))[0].notes
    assert any("steps of 0.00391 m (32-bit floats" in n for n in notes)


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("corner", [(0.0, 0.0, 0.0), WORLD])
def test_fine_steps_are_not(tmp_path: Path, kind: str, corner: tuple[float, float, float]) -> None:
    if kind == "e57" and corner == WORLD:
        pytest.skip("pye57 writes single precision")
    for xyz in (points(corner), points(corner) * [1, 0, 1] + np.array(corner) * [0, 1, 0]):
        notes = read_scans(write(tmp_path, kind, xyz))[0].notes
        assert not any("steps" in n for n in notes)


def test_type_of_a_ply_file_counts_for_few_points(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"steps of 0.5 m"):
        read_scans(write(tmp_path, "ply", points(WORLD)[:2], "float"))
    notes = read_scans(write(tmp_path, "ply", points((60_000.0, 0, 0))[:2], "float"))[0].notes
    assert any("steps of 0.00391 m" in n for n in notes)
    assert not read_scans(write(tmp_path, "ply", points((0, 0, 0)), "float"))[0].notes[1:]


def test_scales_of_las(tmp_path: Path) -> None:
    import laspy

    def scaled(scale: float) -> Path:
        header = laspy.LasHeader(point_format=3)
        header.scales = np.full(3, scale)
        las = laspy.LasData(header)
        las.x, las.y, las.z = points((0, 0, 0)).T
        las.write(tmp_path / "s.las")
        return tmp_path / "s.las"

    assert not any("steps" in n for n in read_scans(scaled(0.001))[0].notes)
    assert any("steps of 0.01 m:" in n for n in read_scans(scaled(0.01))[0].notes)
    with pytest.raises(FileError, match=r"steps of 0.1 m, too coarse"):
        read_scans(scaled(0.1))


def test_poses_at_world_size_do_not_make_points_coarse(tmp_path: Path) -> None:
    (tmp_path / "a.ptx").write_text(ptx_text(40, 40))
    assert not any("steps" in n for n in read_scans(tmp_path / "a.ptx")[0].notes)


@pytest.mark.parametrize(("name", "factor"), [("mm", 1000.0), ("cm", 100.0)])
def test_small_units_are_told_and_can_be_stated(tmp_path: Path, name: str, factor: float) -> None:
    r = np.random.default_rng(0)
    wall = np.column_stack([r.uniform(0, 20, 4000), np.full(4000, 3.0), r.uniform(0, 15, 4000)])
    path = tmp_path / "a.xyz"
    np.savetxt(path, wall * factor, "%.2f")
    (scan,) = read_scans(path)
    assert any(f'units = "{name}"' in n for n in scan.notes)
    (scan,) = read_scans(ScanSource(path=str(path), units=name))  # type: ignore[arg-type]
    np.testing.assert_allclose(scan.xyz, wall, atol=1e-4)
    assert not any("units" in n for n in scan.notes)


def test_metres_are_not_doubted(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.xyz", points((0, 0, 0)), "%.3f")
    assert not any("units" in n for n in read_scans(tmp_path / "a.xyz")[0].notes)


def test_our_own_e57_is_fine(tmp_path: Path) -> None:
    from dataclasses import replace

    from frontage.geometry.rigid import Rigid3
    from frontage.io.poses import given_pose

    pose = given_pose(Rigid3("local", "scanner", np.eye(3), np.array([1.25, 2.5, 1.6])))
    scan = replace(Scan("a", points((0, 0, 0)), UTM), local_from_scanner=pose)
    (again,) = read_scans(write_own_e57(tmp_path / "a.e57", [scan]))
    assert not any("steps" in n for n in again.notes)
