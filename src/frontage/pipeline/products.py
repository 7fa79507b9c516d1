"""Products that need an extra: written where it is installed, told of where it is not."""

from collections.abc import Callable, Sequence
from pathlib import Path

from frontage.errors import MissingExtra
from frontage.exports.survey import Survey
from frontage.pipeline.notes import listed
from frontage.pipeline.store.store import Store


def optional(store: Store, files: Sequence[Path], write: Callable[[], None]) -> str:
    """Write files for which an extra is needed; without it remove older ones, and return a note."""
    try:
        write()
    except MissingExtra as error:
        for file in files:
            file.unlink(missing_ok=True)
        names = ", ".join(file.name for file in files)
        return f"{names} left out: {error}, then run `frontage export` on this folder"
    store.wrote(*files)
    return ""


def without(names: Sequence[str], what: str) -> tuple[str, ...]:
    """Return the note that names the facades or buildings a product lacks; empty if it lacks none."""
    return (f"{what}: {listed(names)}.",) if names else ()


def untold(survey: Survey) -> tuple[str, ...]:
    """Return what products leave out, without what stages have warned of already."""
    warned = {text for building in survey.buildings for text in building.missing}
    return tuple(text for text in survey.left_out if text not in warned)
