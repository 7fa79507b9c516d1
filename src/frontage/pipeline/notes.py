"""Notes on facades, told once for all that share them."""

from collections import defaultdict
from collections.abc import Iterable, Sequence

from frontage.pipeline.store.results import NotedItemResult

_NAMED = 4  # that a sentence names, before it counts the rest


def shared_notes(parts: Iterable[NotedItemResult], what: str = "openings") -> list[str]:
    """Return every note on the facades once, with the facades that share it; `what`: of them it tells."""
    facades: dict[str, list[str]] = defaultdict(list)
    for part in parts:
        for name, notes in part.notes.items():
            for note in notes:
                facades[note.removeprefix(f"facade {name}: ")].append(name)
    return [f"{what} of {listed(names)}: {note}" for note, names in facades.items()]


def listed(names: Sequence[str]) -> str:
    """Return the first names, and how many more there are."""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
