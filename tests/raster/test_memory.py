"""What needs more memory than there is ends before the work, with the likely cause."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import ortho_wall as wall
from frontage.buildings import find_buildings
from frontage.errors import InputError
from frontage.model import Scan, WorldRef
from frontage.openings.wall.raster import WallRaster
from frontage.ortho import OrthoOptions, make_ortho
from frontage.raster import memory


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine with 1 GiB of memory."""
    monkeypatch.setattr(memory, "available_memory", lambda: memory.GIB)


def in_millimetres():
    """A wall of 8 x 6 m and its scan, in millimetres."""
    facade = wall.facade(8.0, 6.0, spacing=20.0)
    scan = wall.wall_cloud(facade)
    return replace(facade, outline=facade.outline * 1000.0), scan


def test_an_ortho_image_of_a_wall_in_millimetres() -> None:
    facade, scan = in_millimetres()
    with pytest.raises(InputError, match="800040 x 600040 pixels; the coordinates are probably not"):
        make_ortho(facade, scan)


def test_an_ortho_image_that_fits_no_memory(small: None) -> None:
    facade = wall.facade(8.0, 6.0)
    message = r"needs 1\.84 GiB of memory, and 1 GiB are available; choose a larger gsd"
    with pytest.raises(InputError, match=message) as e:
        make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(gsd=0.0007))
    assert e.value.code == "I322"


def test_an_ortho_image_that_fits_no_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory.shutil, "disk_usage", lambda folder: SimpleNamespace(free=1e9))
    facade = wall.facade(8.0, 6.0)
    with pytest.raises(InputError, match="GiB are free; choose a larger gsd"):
        make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(gsd=0.0002))


def test_a_street_in_millimetres(small: None) -> None:
    scan = wall.wall_cloud(wall.facade(8.0, 6.0))
    large = Scan("wall", scan.xyz * 1000.0, WorldRef(np.zeros(3), None))
    with pytest.raises(InputError, match=r"a front of \d+ x \d+ m needs .* probably not in metres"):
        find_buildings(large)


def test_openings_of_a_wall_in_millimetres(small: None) -> None:
    with pytest.raises(InputError, match=r"8000\.0 x 6000\.0 m in cells of 0\.05 m needs .* not in metres"):
        WallRaster.over(in_millimetres()[0], 0.05)


def test_the_available_memory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = memory.available_memory()
    assert found is not None and found > 1e8
    (tmp_path / "meminfo").write_text("MemTotal: 9000 kB\nMemAvailable:    5000 kB\n")
    monkeypatch.setattr(memory, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory, "_GROUP", tmp_path)
    assert memory.available_memory() == 5000 * 1024
    (tmp_path / "memory.max").write_text("max\n")
    assert memory.available_memory() == 5000 * 1024
    (tmp_path / "memory.max").write_text("3000\n")
    (tmp_path / "memory.current").write_text("2000\n")
    (tmp_path / "memory.stat").write_text("anon 1200\ninactive_file 500\n")
    assert memory.available_memory() == 1500
