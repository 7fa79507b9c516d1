"""Arguments and arrays that cannot be meant are refused, wherever they come from."""

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from frontage.errors import FileError, InputError
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.ply import write_ply
from frontage.io.scans.read import ScanSource, read_scans
from frontage.io.scans.subset import cropped, thinned
from frontage.model import Scan
from io_files import UTM, cloud


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_las(tmp_path / "a.laz", cloud())


@pytest.mark.parametrize("resolution", [0, 0.0, -1.0, np.nan, np.inf, -np.inf, 1j, "1", [1.0]])
def test_resolutions(path: Path, resolution: object) -> None:
    for action in (lambda: read_scans(path, resolution=resolution), lambda: thinned(cloud(), resolution)):
        with pytest.raises(InputError, match="positive length"):
            action()


@pytest.mark.parametrize(
    "bounds",
    [(9, 9, 0, 0), (0, 0, 0, 0), (0, 0, np.nan, 9), (0, 0, np.inf, 9), (0, 0, 9), (0, 0, 9, 9, 9), (0, 0, 9j, 9), "abcd", (0, 0, 9, 9, 9, 5)],  # noqa: E501
)  # fmt: skip
def test_bounds(path: Path, bounds: tuple[float, ...]) -> None:
    for action in (lambda: read_scans(path, bounds=bounds), lambda: cropped(cloud(), bounds)):
        with pytest.raises(InputError, match="bounds"):
            action()


@pytest.mark.parametrize("about", [{"offset": (0, np.nan, 0)}, {"offset": (np.inf, 0, 0)}, {"sigma_range": np.inf}, {"sigma_position": np.nan}])  # fmt: skip  # noqa: E501
def test_statements_about_a_scan(about: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        ScanSource(path="a.laz", **about)  # type: ignore[arg-type]


def test_arrays_of_a_scan() -> None:
    xyz = np.zeros((2, 3))
    with pytest.raises(ValueError, match="complex"):
        Scan("a", xyz + 1j, UTM)
    with pytest.raises(ValueError, match="there are 0 origins"):
        Scan("a", xyz, UTM, origin_index=[0, 0])
    with pytest.raises(ValueError, match="there are 1 origins"):
        Scan("a", xyz, UTM, np.zeros((1, 3)), [0, 1])
    with pytest.raises(ValueError, match="from -2"):
        Scan("a", xyz, UTM, np.zeros((1, 3)), [0, -2])
    with pytest.raises(ValueError, match="origins holds"):
        Scan("a", xyz, UTM, np.full((1, 3), np.nan), [0, 0])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_points_that_are_not_finite_are_never_written(tmp_path: Path, value: float) -> None:
    xyz = np.zeros((3, 3))
    xyz[1, 2] = value
    for write in (write_las, write_ply):
        with pytest.raises(ValueError, match="not finite"):
            write(tmp_path / "a.laz", Scan("a", xyz, UTM))
    assert not list(tmp_path.iterdir())


def test_fine_resolutions_of_wide_scans_do_not_overflow() -> None:
    xyz = np.array([[0.0, 0, 0], [1e7, 1e7, 1e7], [1e7, 1e7, 1e7], [5, 5, 5]])
    np.testing.assert_array_equal(thinned(Scan("a", xyz, UTM), 1e-3).xyz, xyz[[0, 1, 3]])


@pytest.mark.parametrize("suffix", ["xyz", "ply"])
def test_absurd_coordinates_are_dropped_or_refused(tmp_path: Path, suffix: str) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nend_header\n"  # noqa: E501
    path = tmp_path / f"a.{suffix}"

    def write(*rows: str) -> Path:
        path.write_text((head.format(len(rows)) if suffix == "ply" else "") + "\n".join(rows) + "\n")
        return path

    scan = read_scans(write("678001 5403001 3", "1e308 2 3", "1 -1e308 3", "1 2 1e30", "678002 5403002 4", "678003 5403002 4", "678003 5403002 5"))[0]  # fmt: skip  # noqa: E501
    assert len(scan) == 4 and any("3 points" in n and "dropped" in n for n in scan.notes)
    assert np.abs(scan.xyz).max() < 10
    with pytest.raises(FileError, match="no points"):
        read_scans(write("1e308 1e308 1e308", "-1e308 1e308 1e308"))
