"""Finds the bars of every window of a facade: paper B, section 3.3, and the better estimator."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from frontage.crossbars.collect import collect_windows
from frontage.crossbars.evidence import bars_by_evidence
from frontage.crossbars.found import FoundBars, WindowEvidence
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.paper.find import bars_by_edges
from frontage.crossbars.window import Window
from frontage.geometry.arrays import Array
from frontage.model import Elements, Facade, Glazing, Photo, Scan


def find_bars(
    facade: Facade,
    elements: Elements,
    photos: Sequence[Photo],
    image_of: Callable[[str], Array],
    scan: Scan | None,
    options: CrossbarOptions | None = None,
) -> FoundBars:
    """Returns the elements of a facade with the glazing of their windows, and what it was chosen from.

    photos    the oriented photos; `Opening.photos` names those that show an opening
    image_of  returns the pixels (h, w, 3) uint8 RGB of a photo
    scan      the cloud that `facade.support` counts in; None = photos only

    Doors, gates and passages keep what they have; so does every opening with method "none".
    """
    options = options or CrossbarOptions()
    if options.method == "none":
        return FoundBars(elements, ())
    windows = collect_windows(facade, elements, photos, image_of, scan)
    if options.method == "paper":
        found = [_bare(w, g) for w, g in zip(windows, bars_by_edges(windows, options), strict=True)]
    else:
        found = bars_by_evidence(windows, options)
    glazing = {one.opening: one.glazing for one in found}
    openings = tuple(replace(o, glazing=glazing.get(o.id, o.glazing)) for o in elements.openings)
    return FoundBars(replace(elements, openings=openings), tuple(found))


def _bare(window: Window, glazing: Glazing) -> WindowEvidence:
    """Returns the glazing of a window without pictures."""
    (x0, z0), (x1, z1) = window.ring.min(0), window.ring.max(0)
    extent = (float(x0), float(z0), float(x1), float(z1))
    return WindowEvidence(window.opening.id, extent, (), None, glazing)
