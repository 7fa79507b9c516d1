"""Every file that a scan reader opens is in the list that the format declares."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from frontage.errors import FileError
from frontage.io.colmap import colmap_files, read_colmap
from frontage.io.scans.formats import FORMATS
from frontage.io.scans.npz import save_scan
from frontage.io.scans.read import ScanSource, read_scans, scan_inputs
from io_files import cloud, whole_files, write_colmap_binary, write_colmap_text, write_json, write_laspy

_opened: list[set[Path]] = []


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if _opened and event == "open" and isinstance(arguments[0], str | bytes | Path):
        _opened[-1].add(Path(str(arguments[0])).resolve())


sys.addaudithook(_hook)


@contextmanager
def opened_below(folder: Path) -> Iterator[set[Path]]:
    """The files below the folder that the block opens; complete when the block has ended."""
    found: set[Path] = set()
    _opened.append(found)
    try:
        yield found
    finally:
        _opened.pop()
        found &= {p.resolve() for p in folder.rglob("*")}


def agree(folder: Path, source: ScanSource | Path) -> set[str]:
    """The names of the declared files, checked to be at least those that reading opens."""
    with opened_below(folder) as opened:
        read_scans(source)
    declared = {p.resolve() for p in scan_inputs(source)}
    assert opened and opened <= declared
    return {str(p.relative_to(folder.resolve())) for p in declared}


def test_every_format_declares_what_it_opens(tmp_path: Path) -> None:
    good = whole_files(tmp_path)
    save_scan(tmp_path / "s.npz", cloud())
    seen = set()
    for path in [*good.values(), tmp_path / "s.npz"]:
        agree(tmp_path, path)
        seen.add(next(f.name for f in FORMATS if f.fits(path)))
    assert seen == {f.name for f in FORMATS}


def mobile(folder: Path) -> Path:
    xyz = np.random.default_rng(0).uniform(0, 9, (50, 3))
    return write_laspy(folder / "s.las", xyz, 6, gps_time=np.linspace(500, 510, 50))


def test_stations_and_trajectories_are_inputs(tmp_path: Path) -> None:
    path = mobile(tmp_path)
    assert agree(tmp_path, path) == {"s.las"}
    places = [{"station": 0, "position": [0, 0, 0]}]
    write_json(tmp_path / "s.las.stations.json", places)
    assert agree(tmp_path, path) == {"s.las", "s.las.stations.json"}
    other = write_json(tmp_path / "other.json", places)
    assert agree(tmp_path, ScanSource(path=str(path), stations=str(other))) == {"s.las", "other.json"}
    track = tmp_path / "track.csv"
    track.write_text("gps_time,x,y,z\n500,0,0,2\n510,9,9,2\n")
    assert agree(tmp_path, ScanSource(path=str(path), trajectory=str(track))) == {"s.las", "track.csv"}


@pytest.mark.parametrize("write", [write_colmap_text, write_colmap_binary])
def test_the_poses_of_a_colmap_model_are_inputs(tmp_path: Path, write: Any) -> None:
    write(tmp_path / "sparse" / "0")
    kind = "txt" if write is write_colmap_text else "bin"
    names = {f"sparse/0/{name}.{kind}" for name in ("points3D", "images", "cameras")}
    assert agree(tmp_path, tmp_path) == names
    assert agree(tmp_path, tmp_path / "sparse" / "0" / f"points3D.{kind}") == names
    with opened_below(tmp_path) as opened:
        read_colmap(tmp_path)
    assert opened == {p.resolve() for p in colmap_files(tmp_path)} and len(opened) == 2
    with pytest.raises(FileError, match="no COLMAP model"):
        colmap_files(tmp_path.parent)
