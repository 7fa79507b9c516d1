"""Mosaics from one, two and three photos: what the scan did not see must be told from the wall by colours."""

from dataclasses import replace

import numpy as np

from _common import bootstrap, figure, table
from _mosaics import Street, StreetCase, front, record, seen_wall
from _mosaicscore import covered, painted_behind
from frontage.model import NOT_SEEN, OrthoImage
from frontage.ortho import OrthoOptions, make_ortho

CASES = (
    StreetCase(seed=404, exposure=0.5, overcast=0.4, trees=2, cars=2, people=6),
    StreetCase(seed=505, exposure=0.5, overcast=0.3, trees=2, cars=3, people=6),
    StreetCase(seed=606, exposure=0.5, overcast=0.9, trees=2, cars=2, people=6),
)
SETS = (((3,), (1, 5), (0, 3, 6)), ((3,), (1, 5), (2, 4)), ((3,), (1, 5), (0, 3, 6)))
"""Of the seven photos of each street, those that are taken."""
OPTIONS = OrthoOptions(gsd=0.02)


def few_photos(quick: bool) -> None:
    """Prints the share of what stands before facades that is painted, by the number of photos."""
    found: dict[int, list[tuple[float, float, float]]] = {}
    for case, sets in zip(CASES[: 1 if quick else None], SETS, strict=False):
        street = record(case)
        for taken in sets:
            for house in range(len(street.scene.houses)):
                found.setdefault(len(taken), []).append(_measured(_with(street, taken), house))
    rows = []
    for count in sorted(found):
        values = 100.0 * np.array(found[count])
        shown = [figure(bootstrap(column), "%") for column in values.T]
        rows.append([count, len(values), f"{values[:, 0].mean():.2g} %", *shown])
    head = ["photos", "facades", "occluder, mean", "occluder, median", "wall", "glass"]
    table("Facades that few photos see, at 2 cm", head, rows)


def _with(street: Street, taken: tuple[int, ...]) -> Street:
    """The street with some of its photos."""
    photos, moments = (tuple(every[k] for k in taken) for every in (street.photos, street.moments))
    return replace(street, photos=photos, moments=moments)


def _measured(street: Street, house: int) -> tuple[float, float, float]:
    """Shares of occluders painted, and of wall and glass painted that a photo sees."""
    ortho = make_ortho(
        front(street, house), street.scan, street.photos, street.images.__getitem__, options=OPTIONS
    )
    assert isinstance(ortho, OrthoImage), ortho
    truth = seen_wall(street, house, ortho)
    names = [p.id for p in street.photos]
    number = np.array([0, *(names.index(s) + 1 if s in names else 0 for s in ortho.sources)])
    source = number[np.where(ortho.source == NOT_SEEN, 0, ortho.source)]
    known = source != 0
    return (
        painted_behind(source, truth),
        covered(known, truth.wall, truth),
        covered(known, truth.glass, truth),
    )
