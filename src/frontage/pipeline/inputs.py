"""Which files a project reads, with sizes and hashes: for the manifest, and what the markers depend on."""

import glob
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from frontage.errors import FileError
from frontage.pipeline.files import file_hash
from frontage.pipeline.project import Project

Inputs = dict[str, list[dict[str, Any]]]


def hash_inputs(project: Project) -> Inputs:
    """`{"scans": [{"path", "size", "sha256"}, ...], "photos": [...], "model": [...]}`.

    Raises FileError for a file that is missing or cannot be read.
    """
    groups: dict[str, Iterator[Path]] = {"scans": _scan_files(project)}
    groups["photos"] = _photo_files(project)
    groups["model"] = iter([Path(project.model.path)] if project.model else [])
    return {name: [_entry(path) for path in dict.fromkeys(files)] for name, files in groups.items()}


def _scan_files(project: Project) -> Iterator[Path]:
    for scan in project.scans:
        path = Path(scan.path)
        yield from _colmap_files(path, "points3D") if path.is_dir() else [path]
        for extra in (scan.trajectory, scan.stations):
            if extra is not None:
                yield Path(extra)
        beside = path.with_name(path.name + ".stations.json")
        if beside.is_file():
            yield beside


def _photo_files(project: Project) -> Iterator[Path]:
    source = project.photos
    if source is None:
        return
    for pattern in source.path if isinstance(source.path, list | tuple) else [source.path]:
        path = Path(pattern)
        if path.is_dir():
            yield from (p for p in sorted(path.rglob("*")) if p.is_file())
        elif path.is_file() or not glob.has_magic(str(path)):
            yield path
        else:
            yield from (Path(p) for p in sorted(glob.glob(str(path), recursive=True)))
    if source.cameras is not None:
        folder = Path(source.cameras)
        yield from _colmap_files(folder) if folder.is_dir() else [folder]


def _colmap_files(folder: Path, stem: str = "*") -> Iterator[Path]:
    yield from sorted(p for p in folder.glob(f"{stem}.*") if p.suffix in (".txt", ".bin"))


def _entry(path: Path) -> dict[str, Any]:
    try:
        return {"path": str(path), "size": path.stat().st_size, "sha256": file_hash(path)}
    except FileNotFoundError:
        raise FileError(path, "no such file", "check the path") from None
    except OSError as error:
        raise FileError(
            path, f"cannot be read ({error.strerror})", "check the path and its permissions"
        ) from None
