"""Why a photo could not be oriented, each in one sentence; and which photos are duplicates."""

from collections.abc import Sequence

import numpy as np

from frontage.model import Photo
from frontage.orientation.nouns import KeyPoints, PairMatches
from frontage.orientation.ties.options import TieOptions

_SAME_PX = 0.5  # median displacement of the matches of two copies of a picture
_SAME_SHARE = 0.4  # of the key points, that match in two copies
_FEW = 300  # key points
_ONE_PLACE = np.radians(0.5)  # median parallax of two photos

_COPY = "it shows the same picture as"


def duplicates(
    photos: Sequence[Photo], keypoints: Sequence[KeyPoints], pairs: Sequence[PairMatches]
) -> dict[int, int]:
    """Numbers of photos that show the same picture as an earlier one, with the number of that one."""
    copies: dict[int, int] = {}
    for pair in sorted(pairs, key=lambda p: (p.first, p.second)):
        i, j = sorted((pair.first, pair.second))
        a, b = photos[i].camera, photos[j].camera
        if (a.width, a.height) != (b.width, b.height) or i in copies or j in copies:
            continue
        first, second = keypoints[pair.first], keypoints[pair.second]
        moved = np.abs(first.pixels[pair.rows[:, 0]] - second.pixels[pair.rows[:, 1]]).max(1)
        if len(pair.rows) >= _SAME_SHARE * min(len(first), len(second)) and np.median(moved) < _SAME_PX:
            copies[j] = i
    return copies


def reason(
    number: int,
    photos: Sequence[Photo],
    keypoints: Sequence[KeyPoints],
    pairs: Sequence[PairMatches],
    options: TieOptions,
) -> str:
    """Why a photo is in no block, in one sentence; `pairs` are all that matched."""
    mine = [p for p in pairs if number in (p.first, p.second)]
    points = keypoints[number]
    if not mine:
        alone = "matches no other photo"
        if points.sharpness > options.blurred:
            return f"it is blurred (the finest edges are {points.sharpness:.1f} px wide) and {alone}"
        return f"it has only {len(points)} key points and {alone}" if len(points) < _FEW else f"it {alone}"
    if all(p.rival > options.rival for p in mine):
        return "it fits other photos in several places along the wall, because the windows repeat"
    best = max(mine, key=lambda p: len(p.rows))
    other = photos[best.second if best.first == number else best.first].id
    if best.angle < _ONE_PLACE:
        return f"it was taken from the same place as {other} and matches too little from elsewhere"
    return (
        f"its matches (most of them, {len(best.rows)}, with {other}) are too few "
        "or contradict the other photos, so it could not be joined to a block"
    )


REPEATED = (
    "it fits two places along the wall, because the windows repeat; "
    "give approximate poses or photos with more overlap"
)


def few_points(count: int) -> str:
    """The reason of a photo that lost its tie points in the adjustment."""
    return (
        f"only {count} of its tie points are confirmed by other photos, which is too few to trust its place"
    )


CONTRADICTION = "the place that its few matches give contradicts its approximate pose"


def copy_of(other: str) -> str:
    """The reason of a duplicate."""
    return f"{_COPY} {other}, which is used"


def is_copy(reason: str) -> bool:
    """Whether a reason is that of a duplicate."""
    return reason.startswith(_COPY)
