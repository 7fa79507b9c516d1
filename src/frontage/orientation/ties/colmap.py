"""The only door to pycolmap (extra `photos`): cameras, silence, and the import with one clear sentence."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from frontage.errors import MissingExtra
from frontage.model import Camera


def require() -> Any:
    """Returns the module pycolmap. Raises MissingExtra, which names the extra, when it is not installed."""
    if sys.modules.get("pycolmap") is not None:
        return sys.modules["pycolmap"]
    before = signal.getsignal(signal.SIGTERM)
    try:
        import pycolmap
    except ImportError as problem:
        raise MissingExtra("orienting photos to one another", "photos") from problem
    # Its logging library prints the stack of a process that is asked to end; the handler before is put back.
    with suppress(ValueError):  # only the main thread may
        signal.signal(signal.SIGTERM, before if before is not None else signal.SIG_DFL)
    return pycolmap


@contextmanager
def silent() -> Iterator[Any]:
    """Gives pycolmap with its log switched off, which would otherwise fill the terminal."""
    colmap = require()
    log = colmap.logging
    before = log.minloglevel, log.stderrthreshold
    log.minloglevel = log.stderrthreshold = int(log.Level.FATAL)
    try:
        yield colmap
    finally:
        log.minloglevel, log.stderrthreshold = before


def camera_to_colmap(colmap: Any, camera: Camera, number: int = 1) -> Any:
    """Returns the camera as COLMAP's; models and conventions are the same."""
    return colmap.Camera(
        camera_id=number,
        model=camera.model,
        width=camera.width,
        height=camera.height,
        params=camera.params.copy(),
        has_prior_focal_length=True,
    )


def camera_from_colmap(camera: Any) -> Camera:
    """Returns COLMAP's camera as ours."""
    return Camera(camera.model_name, camera.width, camera.height, camera.params)
