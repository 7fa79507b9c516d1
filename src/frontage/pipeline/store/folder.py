"""The skeleton of a run folder: its places, its manifest, its markers, and a record of what is written."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from frontage.errors import WorkspaceError
from frontage.io.files import MALFORMED
from frontage.pipeline.store.files import read_json, write_bytes, write_json
from frontage.pipeline.store.manifest import Manifest
from frontage.pipeline.store.markers import Markers


class Folder:
    """A run folder without its nouns."""

    def __init__(self, out: Path | str) -> None:
        """Open an existing run folder. Raises WorkspaceError if it is none."""
        self.out = Path(out)
        self.markers = Markers(self.out)
        self._written: list[Path] = []
        if self.out.exists() and not self.out.is_dir():
            raise WorkspaceError(f"{self.out} is a file, not a run folder; give another name")
        if not self.manifest_path.is_file():
            raise WorkspaceError(
                f"{self.out} is not a run folder (it has no manifest.json); `frontage run` makes one"
            )

    @classmethod
    def create(cls, out: Path | str) -> Self:
        """Open a run folder; create it if it does not exist. Raises WorkspaceError if it cannot be one."""
        path = Path(out)
        if path.exists() and not path.is_dir():
            raise WorkspaceError(f"{path} is a file; give another name for the run folder")
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not _readable(path / "manifest.json"):
                write_json(path / "manifest.json", {})
        except OSError as error:
            raise WorkspaceError(
                f"{path} cannot be written ({error.strerror}); give another run folder"
            ) from None
        return cls(path)

    @property
    def manifest_path(self) -> Path:
        """OUT/manifest.json."""
        return self.out / "manifest.json"

    def manifest(self) -> Manifest:
        """Return the manifest. Raises WorkspaceError if it cannot be read."""
        try:
            return Manifest.from_json(read_json(self.manifest_path))
        except (OSError, *MALFORMED) as error:
            raise WorkspaceError(
                f"{self.manifest_path} cannot be read ({error}); run `frontage run` again"
            ) from None

    def save_manifest(self, manifest: Manifest) -> None:
        """Write the manifest."""
        write_json(self.manifest_path, manifest.to_json())

    @contextmanager
    def recording(self) -> Iterator[list[Path]]:
        """Collect the files that are written in the block."""
        before, self._written = self._written, []
        try:
            yield self._written
        finally:
            self._written = before

    def wrote(self, *paths: Path) -> None:
        """Take note of files that were written."""
        self._written.extend(paths)

    def put(self, path: Path, data: bytes) -> None:
        """Write a file of bytes."""
        write_bytes(path, data)
        self.wrote(path)

    @property
    def registration_folder(self) -> Path:
        """OUT/registration."""
        return self.out / "registration"

    @property
    def orientation_folder(self) -> Path:
        """OUT/orientation."""
        return self.out / "orientation"

    @property
    def buildings_folder(self) -> Path:
        """OUT/buildings."""
        return self.out / "buildings"

    def facade_folder(self, facade: str) -> Path:
        """OUT/facades/B07_F1 of "B07/F1"."""
        return self.out / "facades" / facade.replace("/", "_")

    @property
    def model_folder(self) -> Path:
        """OUT/model."""
        return self.out / "model"

    @property
    def products_folder(self) -> Path:
        """OUT/products."""
        return self.out / "products"


def _readable(path: Path) -> bool:
    try:
        Manifest.from_json(read_json(path))
    except (OSError, *MALFORMED):
        return False
    return True
