"""E57, PTX and Frontage's own scan files keep the beams that did not return."""

import numpy as np
import pytest

from frontage.io.scans.e57write import write_e57
from frontage.io.scans.npz import load_scan, save_scan
from frontage.io.scans.ptx import write_ptx
from frontage.io.scans.read import read_scans
from frontage.io.scans.subset import thinned
from frontage.model import merge_scans
from raster_scans import WORLD, scan_raster, tilted, within


@pytest.mark.parametrize("suffix", [".e57", ".ptx"])
def test_readers_keep_beams_that_did_not_return(tmp_path, suffix):
    scan, lost = scan_raster(within((3.0, 1.0, 6.0, 4.0)), tilted(degrees=1.0))
    path = tmp_path / f"a{suffix}"
    {".e57": write_e57, ".ptx": write_ptx}[suffix](path, [scan])
    (back,) = merge_scans(read_scans(path, world=WORLD)).no_returns
    d = back.directions
    assert max(np.linalg.norm(d - w, axis=1).min() for w in lost[::29]) < 1e-5


def test_scans_in_a_run_folder_keep_them(tmp_path):
    cloud = merge_scans([scan_raster(within((3.0, 1.0, 6.0, 4.0)), tilted(degrees=k))[0] for k in (1.0, 2.0)])
    back = load_scan(save_scan(tmp_path / "a.npz", cloud))
    assert len(back.no_returns) == 2
    for a, b in zip(cloud.no_returns, back.no_returns, strict=True):
        assert a.origin == b.origin
        for name in ("axes", "azimuth", "elevation", "lost"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_thinned_clouds_have_none():
    scan, _ = scan_raster(within((3.0, 1.0, 6.0, 4.0)))
    assert not thinned(scan, 0.1).no_returns
