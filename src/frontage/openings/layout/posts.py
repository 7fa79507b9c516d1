"""Posts of joinery between the windows of a band: what they mean for the beams and for the borders."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import TOLERANCES
from frontage.openings.borders.outline import Outline
from frontage.openings.wall.beams import Beams, WallCrossings
from frontage.openings.wall.raster import WallRaster

_LEAST = 0.15  # m: half a brick, the least pier, and the cells that it is cut by


@dataclass(frozen=True)
class Post:
    """A post from x0 to x1, from sill z0 to lintel z1, with its front at y; all m, facade frame.

    Windows meet somewhere in it, where is not seen: its middle half counts as wall. A `level` one is a rail,
    which counts as wall as a whole.
    """

    x0: float
    z0: float
    x1: float
    z1: float
    y: float
    level: bool = False

    @property
    def middle(self) -> float:
        """The middle x, m."""
        return (self.x0 + self.x1) / 2

    @property
    def half(self) -> float:
        """Half the width of the part that counts as wall, m."""
        width = self.x1 - self.x0
        return width / 2 if self.level else min(max(width / 2, _LEAST), width) / 2

    def meets(self, other: "Post") -> bool:
        """Returns whether two posts overlap."""
        across = min(self.x1, other.x1) > max(self.x0, other.x0)
        return across and min(self.z1, other.z1) > max(self.z0, other.z0)

    def holds(self, x: Float, z: Float) -> Bool:
        """Returns which of the places (n,) m lie in the part that counts as wall."""
        return np.asarray((np.abs(x - self.middle) < self.half) & (z > self.z0) & (z < self.z1))


def same_on_most(rasters: Sequence[Sequence[Post]]) -> Iterator[list[tuple[int, int]]]:
    """Yields where the posts are found that stand on most rasters: the numbers of the rasters and posts.

    They come in the order of the first raster that shows them; what overlaps an earlier one is the same.
    """
    told: list[Post] = []
    for post in (post for found in rasters for post in found):
        if any(post.meets(other) for other in told):
            continue
        told.append(post)
        same = [next((n for n, other in enumerate(found) if post.meets(other)), None) for found in rasters]
        numbers = [(k, n) for k, n in enumerate(same) if n is not None]
        if 2 * len(numbers) > len(rasters):
            yield numbers


def cells_held_by(posts: Sequence[Post], raster: WallRaster) -> Bool:
    """Returns the cells (h, w) that posts hold, in part at least."""
    out = np.zeros(raster.shape, np.bool_)
    for post in posts:
        box = np.array([post.middle - post.half, post.z0, post.middle + post.half, post.z1])
        low, high = ((side - raster.corner) / raster.cell for side in (box[:2], box[2:]))
        (c0, r0), (c1, r1) = (
            np.maximum(np.floor(low), 0).astype(int),
            np.maximum(np.ceil(high), 0).astype(int),
        )
        out[r0:r1, c0:c1] = True
    return out


def with_posts(beams: Beams, posts: Sequence[Post]) -> Beams:
    """Returns the beams with posts as parts of the wall, which lies at their depth there.

    What ends the beams before that depth (a blade between two frames) belongs to the post.
    """
    lines = beams.lines
    old = lines.y - beams.depth_at(*lines.place) > beams.least
    lines, moved = _on_posts(lines, posts)
    depth = np.where(moved, lines.y - lines.level, lines.y - beams.depth_at(*lines.place))
    lone, lone_depth = beams.open[int(old.sum()) :], beams.open_depth[int(old.sum()) :]
    x, y, z = beams.points.T
    on, free = np.zeros(len(x), np.bool_), np.ones(len(lone), np.bool_)
    behind, lone_y = y - beams.depth_at(x, z) > beams.least, lone_depth + beams.depth_at(*lone.T)
    rows = np.flatnonzero(behind)
    x, y, z = beams.points[rows].T
    for post in posts:
        on[rows] |= post.holds(x, z) & (y < post.y + TOLERANCES.least_on_wall)
        free &= ~(post.holds(*lone.T) & (lone_y < post.y + TOLERANCES.least_on_wall))
    through = depth > beams.least
    return replace(
        beams,
        solid=np.vstack([beams.solid, beams.points[on][:, [0, 2]]]),
        solid_depth=np.append(beams.solid_depth, np.zeros(int(on.sum()))),
        open=np.vstack([lines.place.T[through], lone[free]]),
        open_depth=np.append(depth[through], lone_depth[free]),
        lines=lines,
    )


def _on_posts(lines: WallCrossings, posts: Sequence[Post]) -> tuple[WallCrossings, Bool]:
    """Returns the lines of sight with those at a post taken at its depth, and which these are.

    A line is at a post if it ends on it, or would cross the wall there.
    """
    ends = lines.shifted(lines.y - lines.level)
    place, level = lines.place.copy(), lines.level.copy()
    moved = np.zeros(len(level), np.bool_)
    for post in posts:
        there = lines.at(post.y)
        some = (post.holds(*there) | post.holds(*lines.place)) & (lines.y > post.y - TOLERANCES.least_on_wall)
        some |= post.holds(*ends) & (lines.y > lines.level) & (lines.y < post.y)
        place[:, some], level[some] = there[:, some], post.y
        moved |= some
    return replace(lines, place=place, level=level), moved


def with_post_borders(outline: Outline, posts: Sequence[Post]) -> Outline:
    """Returns the outline with the borders beside a post put where windows that meet in it end.

    Windows meet anywhere in the middle half of the post. Each ends where that half begins, so that the post
    stays between them. The error is that of a place anywhere in the half.
    """
    found, (_, low, _, high) = outline, outline.place
    for post in (p for p in posts if not p.level and min(high, p.z1) > max(low, p.z0)):
        width = post.x1 - post.x0
        for k, side, towards in ((0, 0, 0.25), (1, 2, -0.25)):
            if abs(outline.place[side] - post.middle) < width:
                found = found.with_border(k, post.middle + towards * width, width / np.sqrt(12.0))
    return found
