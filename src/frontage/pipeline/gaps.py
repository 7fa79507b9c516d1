"""What a run could not make of its buildings, in sentences for whoever opens one of its products."""

from collections.abc import Sequence

from frontage.pipeline.store.store import Store

BEFORE_MODEL = ("buildings", "facades", "ortho", "openings", "crossbars")
"""Stages whose warnings say what is missing on the walls."""
WITH_MODEL = (*BEFORE_MODEL, "model")
"""The same, and what is missing of the model."""


def warnings_of(store: Store, stages: Sequence[str] = WITH_MODEL) -> dict[str, list[str]]:
    """Return what stages warned of, by building."""
    found: dict[str, list[str]] = {}
    for stage, warning in store.manifest().warnings:
        if stage in stages:
            text = f"{warning.item}: {warning.message} [{warning.code}]"
            found.setdefault(warning.item.split("/")[0], []).append(text)
    return found


def gaps(store: Store, stages: Sequence[str] = WITH_MODEL) -> tuple[str, ...]:
    """Return what is missing, as far as `stages` make it: why they failed, and for which facades."""
    warned, records = warnings_of(store, stages), store.building_records()
    found = [text for record in records for text in warned.get(record.id, ())]
    facades = store.facade_ids()
    bare = [r.id for r in records if r.id not in warned and not store.facades_of(r.id)]
    if bare:
        found.append(f"No facade was found of: {_listed(bare)}.")
    unjudged = [name for name in facades if not store.has(name, "openings")]
    if unjudged and "openings" in stages:
        found.append(f"Openings were not found on, or not looked for on: {_listed(unjudged)}.")
    if blind := [name for name in facades if not store.has(name, "ortho")]:
        found.append(f"There is no ortho-image, and so no picture, of: {_listed(blind)}.")
    return tuple(found)


def unmodelled(store: Store) -> tuple[str, ...]:
    """Return which facades are not in the model, if there is a model at all."""
    built = {name for about in store.model().values() for name in about.get("facades", ())}
    lost = [name for name in store.facade_ids() if name not in built] if built else []
    return (f"Not in the model: {_listed(lost)}.",) if lost else ()


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)
