"""The folder of a simulated scene: which files are its own, and whether they are all there and current."""

from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from frontage.errors import WorkspaceError
from frontage.pipeline.store.files import read_json, write_json

_MARKER = "truth/files.json"


class SceneFolder:
    """A folder that a scene is written into.

    made_of  what the scene follows from, by name: each value changes with it
    """

    def __init__(self, out: Path, made_of: Mapping[str, str]) -> None:
        """Raises WorkspaceError when `out` is a file."""
        if out.exists() and not out.is_dir():
            raise WorkspaceError(f"{out} is a file; give another name for the scene's folder")
        self.out, self.made_of = out, dict(made_of)
        self._marker: dict[str, Any] = self._read()

    def current(self) -> bool:
        """Whether the whole scene is there, made of the same."""
        return bool(self._marker) and not self.outdated()

    def outdated(self) -> str:
        """Return why an earlier scene in the folder is made again; empty if it is kept or if none exists."""
        if not (marker := self._marker):
            return ""
        if not marker.get("complete"):
            return "it was not finished"
        before = marker.get("made_of", {})
        if changed := [name for name, value in self.made_of.items() if before.get(name) != value]:
            return f"{' and '.join(changed)} changed"
        lost = [name for name in marker["files"] if not (self.out / name).is_file()]
        return f"{lost[0]} is missing" if lost else ""

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
        self._marker = {"made_of": self.made_of, "complete": complete, "files": list(names)}
        write_json(self.out / _MARKER, self._marker)

    def _read(self) -> dict[str, Any]:
        """The marker; empty when there is none, or what is there is no marker."""
        try:
            marker = read_json(self.out / _MARKER)
        except (OSError, ValueError):
            return {}
        return marker if isinstance(marker, dict) and isinstance(marker.get("files"), list) else {}
