"""Markers: what is finished in a run folder, what it was made from, and the files that it promises.

A stage, or one item of it, is finished when its marker `OUT/.done/<stage>[.<item>].json` exists. The marker
holds the key (a fingerprint of code, options, inputs and of the stages before), the result, and the size and
checksum of every file that was written. The life of a marker:

1. `withdraw` renames it to `<stage>[.<item>].pending` before its files, or files that they follow from,
   are touched. From then on nobody takes the files for current, but they still exist.
2. `finish` removes those files of the pending marker that were not written again, and puts a new marker.
3. `sweep` removes the files of markers that are still pending when a run ends well.

So a run that is killed at any point continues where it was, and no file outlives what it was made from.
"""

from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from frontage.pipeline.store.files import checksum, flush, read_json, write_json


@dataclass(frozen=True)
class Promise:
    """A file that a marker promises: path relative to the run folder, size in bytes, checksum."""

    path: str
    size: int
    checksum: str


@dataclass(frozen=True)
class Marker:
    """A finished stage or item: its key, its result as JSON, its files, and the items of a whole stage."""

    key: str
    result: Any
    files: tuple[Promise, ...] = ()
    items: tuple[str, ...] = ()


class Markers:
    """The markers of one run folder."""

    def __init__(self, out: Path) -> None:
        self._out = out
        self._folder = out / ".done"

    def read(self, stage: str, item: str = "") -> Marker | None:
        """Return the marker of a finished stage or item, None if there is none or it cannot be read."""
        return _read(self._path(stage, item))

    def current(self, stage: str, item: str, key: str, *, thorough: bool = False) -> Marker | None:
        """Return the marker if it has this `key` and all its files are in place, else None.

        Sizes are always compared, checksums only if `thorough`.
        """
        marker = self.read(stage, item)
        if marker is None or marker.key != key:
            return None
        whole = all(self._kept(promise, thorough) for promise in marker.files)
        return marker if whole else None

    def items(self, stage: str) -> list[str]:
        """Return the items of a stage that have a marker, sorted."""
        names = (path.name.removesuffix(".json") for path in self._folder.glob(f"{stage}.?*.json"))
        return sorted(name.removeprefix(f"{stage}.") for name in names)

    def withdraw(self, stage: str, item: str = "") -> None:
        """Declare that the files of a stage or item are about to change, or follow from something that is."""
        path = self._path(stage, item)
        with suppress(FileNotFoundError):
            if (pending := _read(path.with_suffix(".pending"))) is not None:
                marker = _read(path)
                files = {p.path: p for p in (*pending.files, *(marker.files if marker else ()))}
                _write(path, Marker("", None, tuple(files.values())))
            path.rename(path.with_suffix(".pending"))

    def finish(self, stage: str, item: str, marker: Marker, written: Iterable[Path]) -> None:
        """Put `marker`, which promises the files `written`; remove what only the earlier marker promised."""
        paths = sorted(set(written))
        flush(paths)
        files = tuple(
            Promise(path.relative_to(self._out).as_posix(), path.stat().st_size, checksum(path))
            for path in paths
        )
        path = self._path(stage, item)
        self._remove_pending(path.with_suffix(".pending"), {promise.path for promise in files})
        _write(path, Marker(marker.key, marker.result, files, marker.items))
        flush([path])

    def sweep(self, stages: Collection[str] | None = None) -> None:
        """Remove the files that nothing promises any more; only those of the items of `stages` if given.

        Without `stages`, temporary files that a killed run left are removed, too.
        """
        promised = {p.path for m in map(_read, self._folder.glob("*.json")) if m for p in m.files}
        for pending in sorted(self._folder.glob("*.pending")):
            stage, _, item = pending.name.removesuffix(".pending").partition(".")
            if stages is None or (item and stage in stages):
                self._remove_pending(pending, promised)
        if stages is None:
            for torn in sorted(self._out.rglob(".*.part")):  # a killed run was writing them
                torn.unlink(missing_ok=True)

    def _remove_pending(self, pending: Path, keep: set[str]) -> None:
        marker = _read(pending)
        for promise in marker.files if marker else ():
            if promise.path not in keep and ".." not in Path(promise.path).parts:
                self._remove(self._out / promise.path)
        pending.unlink(missing_ok=True)

    def _remove(self, path: Path) -> None:
        """Remove a file and the folders that it leaves empty."""
        path.unlink(missing_ok=True)
        for folder in _up_to(path.parent, self._out):
            try:
                folder.rmdir()
            except OSError:
                break

    def _kept(self, promise: Promise, thorough: bool) -> bool:
        path = self._out / promise.path
        try:
            same = path.is_file() and path.stat().st_size == promise.size
            return same and (not thorough or checksum(path) == promise.checksum)
        except OSError:
            return False

    def _path(self, stage: str, item: str) -> Path:
        return self._folder / (f"{stage}.{item.replace('/', '_')}.json" if item else f"{stage}.json")


def _up_to(folder: Path, top: Path) -> Iterator[Path]:
    while folder != top and top in folder.parents:
        yield folder
        folder = folder.parent


def _read(path: Path) -> Marker | None:
    try:
        table = read_json(path)
        files = tuple(Promise(str(f["path"]), int(f["size"]), str(f["checksum"])) for f in table["files"])
        return Marker(str(table["key"]), table["result"], files, tuple(map(str, table["items"])))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _write(path: Path, marker: Marker) -> None:
    write_json(path, asdict(marker))
