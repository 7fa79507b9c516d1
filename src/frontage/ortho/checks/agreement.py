"""Checks every photo against the coloured scan and the other photos before it paints.

All pictures of a facade are rectified on its surface and compared patch by patch. In a patch, two pictures
agree if the patch of the one resembles the same patch of the other more than any of several patches from
elsewhere on the facade. Pictures that have nothing to do with each other agree by chance, in one of so many
patches; that rate is known exactly, whatever the light, the texture or the repetition of windows, and so is
the probability of every number of agreements (a rank test).

A photo is left out if it agrees no more often than by chance with pictures that agree with others, and if
such a number would be a thousand times less likely of a photo that agrees like the least of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from scipy import stats

from frontage.geometry.arrays import Array
from frontage.model import PhotoRemark
from frontage.ortho.checks.patches import Agreement, Patches, agreement, of_photo, of_scan, similarity
from frontage.ortho.points import FacadePoints
from frontage.ortho.rectified import CellPhotos
from frontage.ortho.surface import ImageOf
from frontage.ortho.views import ViewPlan

Turn = Callable[[Array], Array]
"""Turns the pixels of a picture into the orientation that its file states."""

_LEVEL = 0.001  # of significance: what is so improbable did not happen by chance
_HINT_OF_RELATION = 0.05  # a photo whose agreement is only so improbable by chance is not left out
_PARTNERS = 5  # pictures that a photo is compared with, those that share most with it
_FEWEST_PATCHES = 5  # that tell the two orientations of photos apart
_SCAN, _ODD, _EVEN = "the scan", "odd points", "even points"


@dataclass(frozen=True)
class PhotoCheck:
    """What the comparison found: photos to leave out, photos to turn, and what to tell of them."""

    left_out: frozenset[str] = frozenset()
    turned: frozenset[str] = frozenset()
    remarks: tuple[PhotoRemark, ...] = ()

    def kept(self, plan: ViewPlan | None) -> ViewPlan | None:
        """The plan without the photos to leave out; None where the others see nothing."""
        return None if plan is None else plan.without(self.left_out)

    def images(self, image_of: ImageOf, turns: Mapping[str, Turn]) -> ImageOf:
        """The pictures, those of `turned` photos turned."""
        if not self.turned:
            return image_of
        return lambda name: turns[name](image_of(name)) if name in self.turned else image_of(name)


def check_photos(
    plan: ViewPlan | None, points: FacadePoints, rectified: CellPhotos | None, turns: Mapping[str, Turn]
) -> PhotoCheck:
    """Compares the photos of a plan with each other and with the colours of the scan.

    `rectified` holds the photos on the cells of the plan. `turns` holds the photos of which it is not known
    whether their cameras mean the picture as stored or turned upright; the orientation that agrees better is
    taken for all of them, and where none does they are left out.
    """
    if plan is None or rectified is None:
        return PhotoCheck()
    doubtful = {p.id: turns[p.id] for p in plan.photos if p.id in turns}
    photos, upright = dict[str, Patches](), dict[str, Patches]()
    for number, photo in enumerate(plan.photos):
        shown, clear = plan.quality[number] > 0, plan.clear[number]
        photos[photo.id] = of_photo(rectified(photo, shown), clear)
        if photo.id in doubtful:
            turned = doubtful[photo.id](rectified.image_of(photo.id))
            upright[photo.id] = of_photo(rectified.rectified(photo, turned, shown), clear)
    pairs = _Compared(photos)
    doubted = set(photos) if doubtful else _unrelated(pairs)
    if not doubted:
        return PhotoCheck()
    scan = of_scan(points, plan.cells)
    known = {_SCAN: scan.whole} if scan is not None else {}
    pairs = _Compared({**known, **photos}, pairs.found)
    if scan is not None and not doubtful and all(pairs.related(_SCAN, name) for name in doubted):
        return PhotoCheck()
    check = _orientation(pairs.pictures, upright)
    for name in check.turned:
        photos[name] = upright[name]
    photos = {name: patches for name, patches in photos.items() if name not in check.left_out}
    if doubtful:
        pairs = _Compared({**known, **photos})
    found = {pair: pairs(*pair) for pair in _partners(pairs.pictures)}
    if scan is not None:
        found[_ODD, _EVEN] = agreement(scan.odd, scan.even)
    wrong = [told for name in photos if (told := _contradiction(name, found)) is not None]
    return PhotoCheck(
        check.left_out | {name for name, _ in wrong},
        check.turned,
        (*check.remarks, *(failed for _, failed in wrong)),
    )


@dataclass(frozen=True, eq=False)
class _Compared:
    """Pictures by name, and how pairs of them agree, each compared when it is first asked for."""

    pictures: Mapping[str, Patches]
    found: dict[tuple[str, str], Agreement] = field(default_factory=dict)

    def __call__(self, a: str, b: str) -> Agreement:
        """How picture `a` agrees with `b`."""
        if (a, b) not in self.found:
            self.found[a, b] = agreement(self.pictures[a], self.pictures[b])
        return self.found[a, b]

    def related(self, a: str, b: str) -> bool:
        """Whether two pictures agree more often than by chance; a few places in a row are enough."""
        found = self.found.get((a, b)) or agreement(self.pictures[a], self.pictures[b], _LEVEL)
        return found.count > 0 and found.chance < _HINT_OF_RELATION


def _unrelated(photos: _Compared) -> set[str]:
    """The photos that agree with no other one more often than by chance.

    The others are not left out, whatever the scan shows.
    """
    doubted = set(photos.pictures)
    for a, b in _partners(photos.pictures):
        if (a in doubted or b in doubted) and photos.related(a, b):
            doubted -= {a, b}
    return doubted


def _partners(pictures: Mapping[str, Patches]) -> list[tuple[str, str]]:
    """The pairs of pictures to compare: each with those that share most patches with it."""
    shared = {
        (a, b): len(set(pictures[a].grey) & set(pictures[b].grey)) for a, b in combinations(pictures, 2)
    }
    chosen = set[tuple[str, str]]()
    for name in pictures:
        mine = sorted((pair for pair in shared if name in pair and shared[pair]), key=lambda p: -shared[p])
        chosen.update(mine[:_PARTNERS])
    return sorted(chosen)


def _contradiction(name: str, pairs: Mapping[tuple[str, str], Agreement]) -> tuple[str, PhotoRemark] | None:
    """The photo and why it is left out; None for one that agrees, or of which nothing can be said."""
    mine = {pair: found for pair, found in pairs.items() if name in pair and found.count}
    if not mine or min(found.chance for found in mine.values()) < _HINT_OF_RELATION:
        return None
    related = {pair: found for pair, found in pairs.items() if name not in pair and found.chance < _LEVEL}
    trusted = {one for pair in related for one in pair} | ({_SCAN} if (_ODD, _EVEN) in related else set())
    rates = [found.rate for pair, found in related.items() if pair != (_ODD, _EVEN)]
    if not rates and (_ODD, _EVEN) in related:
        # Nothing but the scan: a photo shows at least half of what the scan shows twice.
        rates = [0.5 * related[_ODD, _EVEN].rate]
    judged = [found for pair, found in mine.items() if trusted & (set(pair) - {name})]
    if not rates or not judged:
        return None
    found = max(judged, key=lambda f: f.count)
    if found.log_likelihood(found.by_chance) - found.log_likelihood(min(rates)) < -np.log(_LEVEL):
        return None
    text = (
        f"photo {name} does not show this facade where its pose says: it agrees with another picture in "
        f"{found.agreeing} of {found.count} places, no more than by chance ({min(rates):.0%} or more were "
        f"expected); it was left out"
    )
    return name, PhotoRemark("F305", text, "check its pose, and whether the file is the photo of this name")


def _orientation(stored: Mapping[str, Patches], upright: Mapping[str, Patches]) -> PhotoCheck:
    """Which of the two orientations of the photos in `upright` agrees better with all other pictures.

    One program made the cameras of all of them, so one answer holds for all.
    """
    if not upright:
        return PhotoCheck()
    turned = {**stored, **upright}
    gains: dict[int, list[float]] = {}
    for a, b in sorted({*_partners(stored), *_partners(turned)}):
        if a not in upright and b not in upright:
            continue
        as_stored, as_turned = similarity(stored[a], stored[b]), similarity(turned[a], turned[b])
        for patch in as_stored.keys() | as_turned.keys():
            gain = as_turned.get(patch, 0.0) - as_stored.get(patch, 0.0)  # sky resembles nothing
            gains.setdefault(patch, []).append(gain)
    means = np.array([np.mean(gains[patch]) for patch in sorted(gains)])
    names = ", ".join(sorted(upright))
    if len(means) < _FEWEST_PATCHES or stats.ttest_1samp(means, 0.0).pvalue > _LEVEL:
        text = (
            f"{names}: the EXIF orientation asks to turn the picture, and neither the colours of the scan "
            f"nor other photos tell whether the cameras mean it so; left out"
        )
        hint = "store the photos as their cameras mean them, and remove the EXIF orientation"
        return PhotoCheck(left_out=frozenset(upright), remarks=(PhotoRemark("F306", text, hint),))
    if means.mean() < 0.0:
        return PhotoCheck()
    text = f"{names}: turned by the EXIF orientation, because only so they agree with the other pictures"
    hint = "nothing needs to be done; without an EXIF orientation there is no doubt"
    return PhotoCheck(turned=frozenset(upright), remarks=(PhotoRemark("F307", text, hint),))
