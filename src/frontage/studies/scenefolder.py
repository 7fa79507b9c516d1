"""The folder of a simulated scene: which files are its own, and whether they are all there and current."""

from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from frontage.errors import WorkspaceError
from frontage.pipeline.store.files import read_json, write_json

_MARKER = "truth/files.json"


class SceneFolder:
    """A folder that a scene is written into. `key` changes with the spec and with the code that writes."""

    def __init__(self, out: Path, key: str) -> None:
        """Raises WorkspaceError when `out` is a file."""
        if out.exists() and not out.is_dir():
            raise WorkspaceError(f"{out} is a file; give another name for the scene's folder")
        self.out, self.key = out, key
        self._marker: dict[str, Any] = self._read()

    def current(self) -> bool:
        """Whether the whole scene of this key is there."""
        marker = self._marker
        return (
            marker.get("key") == self.key
            and bool(marker.get("complete"))
            and all((self.out / name).is_file() for name in marker["files"])
        )

    def begin(self, names: Sequence[str]) -> None:
        """Remove an earlier scene's files; `names` are those of this one, known before the first is written.

        Raises WorkspaceError when the folder holds other things, or cannot be written.
        """
        if not self._marker and self.out.is_dir() and any(self.out.iterdir()):
            raise WorkspaceError(f"{self.out} is not empty and holds no simulated scene; give another folder")
        try:
            for name in self._marker.get("files", ()):
                if ".." not in PurePosixPath(name).parts:
                    (self.out / name).unlink(missing_ok=True)
            self._put(names, False)
        except OSError as error:
            raise WorkspaceError(
                f"{self.out} cannot be written ({error.strerror}); give another folder"
            ) from None

    def finish(self) -> None:
        """Everything is written: the marker keeps the files that are there."""
        self._put([name for name in self._marker["files"] if (self.out / name).is_file()], True)

    def _put(self, names: Sequence[str], complete: bool) -> None:
        self._marker = {"key": self.key, "complete": complete, "files": list(names)}
        write_json(self.out / _MARKER, self._marker)

    def _read(self) -> dict[str, Any]:
        """The marker; empty when there is none, or what is there is no marker."""
        try:
            marker = read_json(self.out / _MARKER)
        except (OSError, ValueError):
            return {}
        return marker if isinstance(marker, dict) and isinstance(marker.get("files"), list) else {}
