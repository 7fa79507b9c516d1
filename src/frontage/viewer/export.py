"""Writes the site as files for any web server."""

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from frontage.errors import FileError, FrontageError
from frontage.viewer.site import Site

_MARK = "run.json"  # an earlier export has it


@dataclass(frozen=True)
class Exported:
    """What was written: the number of files, their bytes, and what could not be made, with the reason."""

    files: int
    size: int
    failed: tuple[str, ...]


def export(site: Site, folder: Path, tell: Callable[[int, int], None] = lambda done, total: None) -> Exported:
    """Write a site into `folder`, which it replaces if an earlier export made it.

    A picture that cannot be read is left out and told; the site says so where it would be. Raises FileError
    if the folder holds something else, or cannot be written.
    """
    target = Path(os.path.abspath(folder))
    if target.exists() and not (target.is_dir() and (_is_export(target) or not any(target.iterdir()))):
        raise FileError(
            folder, "exists and is no earlier export of the viewer", "give an empty or a new folder"
        )
    part = target.with_name(f".{target.name}.part")
    try:
        shutil.rmtree(part, ignore_errors=True)
        made = _write(site, part, tell)
        shutil.rmtree(target, ignore_errors=True)
        part.rename(target)
    except OSError as error:
        raise FileError(
            folder,
            f"cannot be written ({error.strerror})",
            "check the folder and the free space",
            code="I104",
        ) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return made


def _is_export(folder: Path) -> bool:
    return (folder / _MARK).is_file() and (folder / "index.html").is_file()


def _write(site: Site, folder: Path, tell: Callable[[int, int], None]) -> Exported:
    size, count, failed = 0, 0, []
    for done, (name, file) in enumerate(site.files.items(), 1):
        tell(done, len(site.files))
        try:
            data = file.read()
        except FrontageError as error:
            if name == _MARK:
                raise
            failed.append(str(error))
            continue
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        size, count = size + len(data), count + 1
    return Exported(count, size, tuple(dict.fromkeys(failed)))
