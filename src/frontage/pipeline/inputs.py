"""The files that a project reads, with sizes and hashes: for the manifest and for the keys of the stages."""

import glob
from collections.abc import Iterator
from pathlib import Path

from frontage.errors import FileError
from frontage.pipeline.project import Project
from frontage.pipeline.store.files import file_hash
from frontage.pipeline.store.manifest import InputFile, Inputs


def hash_inputs(project: Project) -> Inputs:
    """Return the files of the groups "scans", "photos" and "model".

    Raises FileError for a file that is missing or cannot be read.
    """
    groups: dict[str, Iterator[Path]] = {"scans": _scan_files(project)}
    groups["photos"] = _photo_files(project)
    groups["model"] = iter([Path(project.model.path)] if project.model else [])
    return {name: tuple(_entry(path) for path in dict.fromkeys(files)) for name, files in groups.items()}


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


def _entry(path: Path) -> InputFile:
    try:
        return InputFile(str(path), path.stat().st_size, file_hash(path))
    except FileNotFoundError:
        raise FileError(path, "no such file", "check the path") from None
    except OSError as error:
        raise FileError(
            path, f"cannot be read ({error.strerror})", "check the path and its permissions"
        ) from None
