"""The better estimator of window bars: evidence of rectified views, and an exact search over layouts."""

from collections.abc import Sequence
from dataclasses import replace

from frontage.crossbars.alike import with_one_depth
from frontage.crossbars.chosen import Chosen
from frontage.crossbars.found import WindowEvidence
from frontage.crossbars.judge import glazing
from frontage.crossbars.leaded import are_cames
from frontage.crossbars.observe import Sight, look, observe
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.pictures import evidence_picture, view_pictures
from frontage.crossbars.pooling import choose_layouts
from frontage.crossbars.rivals import margins
from frontage.crossbars.window import Window
from frontage.model import Glazing
from frontage.solve.abreast import each

_TOGETHER = 40  # windows whose evidence is held at once: 0.3 to 0.6 GB


def bars_by_evidence(windows: Sequence[Window], options: CrossbarOptions) -> list[WindowEvidence]:
    """Returns the glazing of every window, and what it was chosen from.

    Similar windows are decided together, among so many at once as memory allows.
    """
    found: list[WindowEvidence] = []
    for first in range(0, len(windows), _TOGETHER):
        found += _judged(windows[first : first + _TOGETHER], options)
    return found


def _judged(windows: Sequence[Window], options: CrossbarOptions) -> list[WindowEvidence]:
    sights = with_one_depth(list(each(look, windows)))
    told = [s for s in sights if s.depth is not None and (s.views or len(s.window.points))]
    chosen = choose_layouts(list(each(observe, told)), options.min_pane)
    sure = margins(chosen)
    found = {id(c.seen.sight): (c, float(m)) for c, m in zip(chosen, sure, strict=True)}
    return list(each(lambda sight: _evidence(sight, found.get(id(sight))), sights))


def _evidence(sight: Sight, found: tuple[Chosen, float] | None) -> WindowEvidence:
    name, extent = sight.window.opening.id, sight.grid.extent
    if found is None:
        why = "the depth of its frame is not known" if sight.window.views else "no photo shows it"
        return WindowEvidence(name, extent, (), None, Glazing(False, depth=sight.depth, note=why))
    chosen, margin = found
    result = glazing(chosen, margin)
    leaded = chosen.seen.leaded or ("panes" if are_cames([bar.width for bar in result.bars]) else "")
    if leaded and result.resolved:
        why = f"a leaded light with small {leaded}: its cames are not told as bars"
        result = replace(result, resolved=False, bars=(), note=why)
    return WindowEvidence(name, extent, view_pictures(sight), evidence_picture(chosen.seen), result)
