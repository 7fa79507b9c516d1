"""A run folder as a site: every file that a browser may ask for, made when it is asked for."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from urllib.parse import unquote

from frontage.errors import FileError
from frontage.pipeline.store.store import Store
from frontage.viewer.bands import BANDS, Blocks
from frontage.viewer.facade import facade_json
from frontage.viewer.overview import overview_json
from frontage.viewer.photos import photo_jpeg
from frontage.viewer.program import program_files
from frontage.viewer.run import Run

_TYPES = {
    ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8", ".json": "application/json; charset=utf-8", ".svg": "image/svg+xml",
    ".jpg": "image/jpeg", ".png": "image/png", ".glb": "model/gltf-binary", ".txt": "text/plain",
}  # fmt: skip


@dataclass(frozen=True)
class SiteFile:
    """A file of the site: its media type, and how its bytes are made."""

    media: str
    read: Callable[[], bytes]


@dataclass(frozen=True)
class Site:
    """The files of a site by their paths; a path that is not among them does not exist."""

    files: dict[str, SiteFile]

    def find(self, path: str) -> SiteFile | None:
        """Return the file of a request's path ("/facades/B01_F1/facade.json"), None if there is none."""
        name = unquote(path.split("?")[0].split("#")[0]).lstrip("/")
        return self.files.get(name or "index.html")


def site_of(store: Store) -> Site:
    """Return the site of a run folder. Raises WorkspaceError for a run without facades or a missing program.

    Nothing is read but what the list of its files needs.
    """
    run = Run(store)
    files = dict(_program())
    files["run.json"] = _made("run.json", partial(overview_json, run))
    for name in run.facades:
        for path, read in _facade_files(run, name):
            files[path] = _made(path, read)
    for number, photo in enumerate(run.photos):
        path = run.photo_path(number)
        files[path] = _made(path, partial(photo_jpeg, run, photo))
    for tile in run.tile_files:
        files[f"tiles/{tile.name}"] = _made(tile.name, partial(_bytes, tile))
    return Site(files)


def _program() -> Iterator[tuple[str, SiteFile]]:
    for name, path in program_files().items():
        yield name, _made(name, partial(_bytes, path))


def _facade_files(run: Run, name: str) -> Iterator[tuple[str, Callable[[], bytes]]]:
    folder, source = run.facade_path(name), run.store.facade_folder(name)
    yield f"{folder}/facade.json", partial(facade_json, run, name)
    for picture in run.evidence(name):
        yield f"{folder}/{picture.name}.png", partial(_bytes, source / f"{picture.name}.png")
    sidecar = run.store.sidecar(name)
    if sidecar is None:
        return
    blocks = Blocks(source, sidecar.size)
    for block in blocks.all():
        yield f"{folder}/{block.name('photo')}.jpg", partial(blocks.picture, block)
        for band in BANDS:
            yield f"{folder}/{block.name(band)}.bin", partial(blocks.band, band, block)


def _made(name: str, read: Callable[[], bytes]) -> SiteFile:
    return SiteFile(_TYPES.get(Path(name).suffix, "application/octet-stream"), read)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})", "run `frontage run` again") from None
