"""The files that a project reads, with sizes and hashes: for the manifest and for the keys of the stages.

The readers themselves say which files they open (`scan_inputs`, `photo_inputs`), so that a changed pose file
counts as much as a changed scan.
"""

from collections.abc import Iterator
from pathlib import Path

from frontage.errors import FileError
from frontage.io.files import require_file
from frontage.io.photos.read import photo_inputs
from frontage.io.scans.read import scan_inputs
from frontage.pipeline.project import Project
from frontage.pipeline.store.files import file_hash
from frontage.pipeline.store.manifest import InputFile, Inputs


def hash_inputs(project: Project) -> Inputs:
    """Return the files of the groups "scans", "photos" and "model".

    Raises FileError for a file that is missing or cannot be read.
    """
    groups: dict[str, Iterator[Path]] = {
        "scans": (path for scan in project.scans for path in scan_inputs(scan)),
        "photos": iter(photo_inputs(project.photos) if project.photos else ()),
        "model": iter([Path(project.model.path)] if project.model else []),
    }
    return {name: tuple(_entry(path) for path in dict.fromkeys(files)) for name, files in groups.items()}


def _entry(path: Path) -> InputFile:
    require_file(path)
    try:
        return InputFile(str(path), path.stat().st_size, file_hash(path))
    except OSError as error:
        raise FileError(
            path, f"cannot be read ({error.strerror})", "check the path and its permissions"
        ) from None
