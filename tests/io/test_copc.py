"""COPC: queries by bounds and by resolution read only the needed nodes and agree with the whole file."""

from pathlib import Path

import numpy as np
import pytest

from copc_files import ORIGIN, SPACING, write_copc
from frontage.geometry.arrays import Float
from frontage.io.scans.read import read_scans


@pytest.fixture
def copc(tmp_path: Path) -> tuple[Path, Float, Float]:
    r = np.random.default_rng(0)
    root = np.round(r.uniform(0, 64, (300, 3)), 3) + ORIGIN
    low = np.round(r.uniform(0, 32, (500, 3)), 3) + ORIGIN
    high = np.round(r.uniform(32, 64, (700, 3)), 3) + ORIGIN
    nodes = {(0, 0, 0, 0): root, (1, 0, 0, 0): low, (1, 1, 1, 1): high}
    return write_copc(tmp_path / "a.copc.laz", nodes), root, np.vstack([root, low, high])


def world(scan: object) -> Float:
    return np.round(scan.world.to_world(scan.xyz), 3)  # type: ignore[attr-defined,no-any-return]


def test_the_whole_file(copc: tuple[Path, Float, Float]) -> None:
    np.testing.assert_allclose(world(read_scans(copc[0])[0]), copc[2], atol=1e-6)


def test_bounds(copc: tuple[Path, Float, Float]) -> None:
    x, y = ORIGIN[:2] + 5
    got = world(read_scans(copc[0], bounds=(x, y, x + 20, y + 20))[0])
    inside = ((copc[2][:, :2] >= [x, y]) & (copc[2][:, :2] <= [x + 20, y + 20])).all(1)
    np.testing.assert_allclose(np.sort(got, 0), np.sort(copc[2][inside], 0), atol=1e-6)


def test_resolution_stops_at_the_level(copc: tuple[Path, Float, Float]) -> None:
    got = world(read_scans(copc[0], resolution=SPACING)[0])
    assert 200 < len(got) <= 300
    assert set(map(tuple, got.round(3))) <= set(map(tuple, copc[1].round(3)))
