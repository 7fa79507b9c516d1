"""The contact sheet "Window bars" of a facade: every window with its pictures and its layout in words."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from frontage.model import Elements, Glazing, Opening
from frontage.report.data import FacadeView, WindowView
from frontage.report.figures import data_uri
from frontage.report.layouts import counted, layout_words

_PAGE = 24  # windows that are shown together; further pages are folded


@dataclass(frozen=True)
class SheetWindow:
    """A window on the sheet: short id, picture ("" = none) and its file, texts, css class."""

    id: str
    picture: str
    file: str
    layout: str
    numbers: str
    panels: str
    css: str


@dataclass(frozen=True)
class SheetPage:
    """Windows that are shown together, and their title."""

    title: str
    windows: list[SheetWindow]


@dataclass(frozen=True)
class BarsSheet:
    """The section: a sentence, pages, and per reason the windows that were not resolved."""

    summary: str
    pages: list[SheetPage]
    unresolved: list[tuple[str, str]]


def bars_sheet(view: FacadeView) -> BarsSheet | None:
    """What the page says of a facade's window bars; None where they were not looked for."""
    windows = glazed(view.elements) if view.elements else []
    if not windows:
        return None
    shots = {shot.opening: shot for shot in view.windows}
    shown = [_window(o, g, shots[o.id], view.folder) for o, g in windows if o.id in shots]
    resolved = [g for _, g in windows if g.resolved]
    bars = sum(len(g.bars) for g in resolved)
    summary = f"Window bars: {len(resolved)} of {len(windows)} windows decided, {bars} bars"
    return BarsSheet(summary, _pages(shown), _unresolved(windows))


def glazed(elements: Elements) -> list[tuple[Opening, Glazing]]:
    """The openings whose bars were looked for, by floor and bay."""
    found = [(o, o.glazing) for o in elements.openings if o.glazing is not None]
    return sorted(found, key=lambda one: (one[0].floor, one[0].bay, one[0].id))


def _window(o: Opening, glazing: Glazing, shot: WindowView, folder: str) -> SheetWindow:
    layout = layout_words(glazing)
    return SheetWindow(
        id=_short(o),
        picture=data_uri(shot.jpeg, "jpeg") if shot.jpeg else "",
        file=f"{folder}/{shot.file}",
        layout=f"{layout}: {glazing.note}" if glazing.note else layout,
        numbers=_numbers(glazing),
        panels="; ".join(shot.panels),
        css="" if glazing.resolved else "unresolved",
    )


def _numbers(glazing: Glazing) -> str:
    """Confidence, the largest standard error of a bar's position, how many photos and whether the scan."""
    if not glazing.resolved:
        return ""
    parts = [f"confidence {glazing.confidence:.2f}"]
    if glazing.bars:
        sigma = max(bar.sigma for bar in glazing.bars)
        parts.append(f"σ at most {1000 * sigma:.1f} mm" if math.isfinite(sigma) else "σ not known")
    photos = sum(source != "scan" for source in glazing.sources)
    parts += [counted(photos, "photo")] if photos else []
    parts += ["scan"] if "scan" in glazing.sources else []
    return ", ".join(parts)


def _pages(shown: Sequence[SheetWindow]) -> list[SheetPage]:
    pages = []
    for first in range(0, len(shown), _PAGE):
        own = list(shown[first : first + _PAGE])
        pages.append(SheetPage(f"{own[0].id} to {own[-1].id}", own))
    return pages


def _unresolved(windows: Sequence[tuple[Opening, Glazing]]) -> list[tuple[str, str]]:
    """Reasons with the windows that they hold for, the most frequent first."""
    found: dict[str, list[str]] = defaultdict(list)
    for o, glazing in windows:
        if not glazing.resolved:
            found[glazing.note or "no reason known"].append(_short(o))
    ordered = sorted(found.items(), key=lambda entry: -len(entry[1]))
    return [(f"{len(ids)} × {reason}", ", ".join(ids)) for reason, ids in ordered]


def _short(o: Opening) -> str:
    return o.id.rpartition("/")[2]
