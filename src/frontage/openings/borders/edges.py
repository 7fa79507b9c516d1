"""The beams at an edge of an opening: which tell solid from open, and where each of them does.

An edge belongs to a solid that reaches from its face (the wall, or a sill or surround before it) into the
wall. Beams that slant away from the opening end on the reveal behind the edge, which is *in sight*; the
others pass the edge of the face, which *hides* what lies behind it. That decides which plane tells the two
sides apart.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.openings.borders.reveals import reveal_line
from frontage.openings.wall.crossings import CrossingBeams

FITTING = 0.15
"""m: sills, surrounds and shutters stand out no further; anything further out only hides the edge."""

FEW = 6
"""Points that a depth needs."""

_SHY = 0.15  # share of the opening's side that is left out at either end: arches, corners, sills
# m, least width of the strip of face beside an edge that shows its depth, and of what lies right behind
_STRIP = 0.03
_SURFACE = 0.3  # share of the points of the fullest surface that the foremost needs
_ROUNDS = 3  # rounds of face and strip, for each needs the other
_COMMON = 0.3  # share of a point's noise that its neighbours share
_SHALLOW = 0.25  # m: echoes of surfaces that near melt into one
_MIXED = (0.2, 0.8)  # shares of the way from the face to the frame between which only mixed echoes lie
_QUANTILES = 1.68  # sigmas of a normal distribution between those shares
_ROUND = 0.01  # m about an edge within which mixed echoes come from
_DILATED = 1.3  # sigmas by which an edge with nothing near behind it seems to stand out: 10 % of the light
_UNSURE = 0.6  # sigmas, error of that; as large where face and frame are not equally bright
_ROUNDING = 1e-6  # m by which places may be off in the choice of what is worth a look
_EXIT = 0.00125  # m, one sigma of a beam that leaves its scanner: 5 mm wide (1/e2)


@dataclass(frozen=True)
class SolidSide:
    """The solid face that ends at an edge: its depth y m, the sigma of that, and its points."""

    y: float
    sigma: float
    points: int


@dataclass(frozen=True)
class EdgeTraits:
    """What the edges of a facade share.

    blur       m, one sigma of the places where solid turns open
    faces      left, right, bottom, top: for edges whose own points do not tell their faces
    widening   rad, one sigma of the angle by which beams widen on their way
    all_blurs  whether the likelihood of all blurs is wanted, not only that of `blur`
    """

    blur: float = 0.002
    faces: tuple[SolidSide | None, ...] = (None, None, None, None)
    widening: float = 0.0
    all_blurs: bool = False


@dataclass(frozen=True)
class Side:
    """Where an edge is looked for: along `axis` (0 = x, 1 = z) about `at` m, the opening on the side `sign`.

    inner   m to the middle of the opening
    reach   m that is searched to either side
    across  m, low and high end of the edge
    loose   whether what stands before the wall may begin off the edge: open shutters do, surrounds do not
    """

    axis: int
    sign: int
    at: float
    inner: float
    reach: float
    across: tuple[float, float]
    loose: bool = False

    @property
    def number(self) -> int:
        """0 left, 1 right, 2 bottom, 3 top."""
        return 2 * self.axis + (self.sign < 0)

    def beside(self, place: Float) -> tuple[Float, Int]:
        """Returns how far (n,) m places (2, n) lie inside the opening, and which of them are near the edge.

        Places at the ends of the edge are left out.
        """
        cut = _SHY * (self.across[1] - self.across[0])
        u = self.sign * (place[self.axis] - self.at)
        some = np.flatnonzero(np.abs(u) < self.reach)
        along = place[1 - self.axis].take(some)
        return u, some[(along > self.across[0] + cut) & (along < self.across[1] - cut)]

    def reached(self, near: CrossingBeams, most: float) -> Int:
        """Returns which of the beams may be near the edge at any depth of up to `most` m about the wall."""
        off = np.abs(near.place[self.axis] - self.at)
        return np.flatnonzero(off < self.reach + _ROUNDING + most * near.steep[self.axis])


@dataclass(frozen=True, eq=False)
class Edge:
    """The beams around an edge, as rising places u (n,) m into the opening from where it is looked for.

    seen     beams that the solid stopped, and those that went through, where the reveal is in sight
    hidden   the same where the face hides the reveal
    stopped  beams that something before the face stopped
    reveal   m, place where the reveal begins by its own points, and its sigma; None where none is in sight
    shift    m, one sigma by which all hidden beams err together: the face's depth and the footprint
    doubt    m, one sigma of the place by the footprint alone
    mixed    mixed echoes, how many there would be per m of the footprint's sigma, and how far away, m
    """

    seen: tuple[Float, Float]
    hidden: tuple[Float, Float]
    stopped: Float
    reveal: tuple[float, float] | None
    face: SolidSide
    shift: float
    doubt: float
    mixed: tuple[float, float, float]
    rays: bool

    @cached_property
    def solid(self) -> Float:
        """All beams that the solid stopped."""
        return np.sort(np.concatenate([self.seen[0], self.hidden[0]]))

    @cached_property
    def opened(self) -> Float:
        """All beams that went through."""
        return np.sort(np.concatenate([self.seen[1], self.hidden[1]]))


def edge_beams(near: CrossingBeams, side: Side, frame: float | None, traits: EdgeTraits) -> Edge:
    """Returns the beams around an edge, each where it crosses the plane that decides on which side it is.

    A beam that the reveal would stop is solid if it ended before a plane 3 sigma within the wall, and counts
    where it crosses that plane, so that the noise of the face does not matter. A beam past the edge of the
    face counts where it passes that, and is solid if most of its light came from the face (it ended less than
    half-way to the frame, which is `frame` m deep).
    """
    rays = near.rays
    u_own, beside = side.beside(near.points)
    face = _face(near, side, beside, traits.faces[side.number])
    begin = max(face.y, 0.0) + near.wall
    back = max(frame - face.y, 2.0 * near.wall) if frame is not None else 2.0 * near.wall
    if not rays:
        return _edge_of_points(u_own[beside], near.depth[beside], face, back, near.wall)
    on = beside[(side.sign * near.slope[side.axis, beside] < 0) & (near.depth[beside] > begin)]
    on = on[near.depth[on] < (0.0 if frame is None else frame - near.wall)]
    own_slope = side.sign * near.slope[side.axis, on]
    reveal = reveal_line(u_own[on], near.depth[on] - max(face.y, 0.0), near.wall / 3.0, own_slope)
    near = near.part(side.reached(near, max(abs(face.y), begin)))
    slope, depth = side.sign * near.slope[side.axis], near.depth
    # a loose shutter beside an edge only bounds it: beams that pass have passed at the wall itself
    back_solid = depth <= max(face.y + back / 2, near.wall)  # the wall behind a sill is solid as well
    edge_y = np.where(back_solid, face.y, max(face.y, 0.0)) if side.loose else face.y
    u, some = side.beside(near.shifted(np.where(slope < 0, begin, edge_y)))
    u, slope, depth, back_solid = u[some], slope[some], depth[some], back_solid[some]
    distance = near.range[some]
    # handles or steps before the face are not part of it
    seen, stopped = slope < 0, depth < max(face.y - 2.0 * near.wall, -FITTING)
    hidden, wide = ~seen & ~stopped, np.sqrt(1.0 + slope**2)
    blurred = wide * footprint(distance, traits.widening)
    way = (depth - face.y) / back
    mixed = (0.0, 0.0, 0.0)
    if back < _SHALLOW:
        mixed = _mixed(u[hidden], way[hidden], wide[hidden], distance[hidden])
    u = np.where(seen, u, u - _far(u[hidden], way[hidden]) * _DILATED * blurred)
    solid = np.where(seen, depth <= begin, back_solid)
    by_sight = [(u[part & solid & ~stopped], u[part & ~solid]) for part in (seen, ~seen)]
    shift, doubt = _errors(u, hidden, slope * face.sigma, blurred)
    return Edge(by_sight[0], by_sight[1], np.sort(u[stopped]), reveal, face, shift, doubt, mixed, rays=True)


def _edge_of_points(u: Float, depth: Float, face: SolidSide, back: float, wall: float) -> Edge:
    """Returns the edge that points of unknown sensors show at u (n,) m, `depth` (n,) m behind the wall.

    They stand for themselves, and the face hides them all. Points of a reveal look like mixed echoes, so that
    the footprint stays unknown.
    """
    none = np.empty(0)
    solid = depth <= max(face.y + back / 2, wall)
    stopped = depth < max(face.y - 2.0 * wall, -FITTING)
    free = len(stopped) - int(np.count_nonzero(stopped))
    shift = _UNSURE * _EXIT if free else 0.0
    doubt = shift * free / max(len(stopped), 1)
    hidden = u[solid & ~stopped], u[~solid]
    before = np.sort(u[stopped])
    return Edge((none, none), hidden, before, None, face, shift, doubt, (0.0, 0.0, 0.0), rays=False)


def footprint(distance: Float, widening: float) -> Float:
    """Returns one sigma (n,) m, across the beam, of footprints at `distance` (n,) m; 0 where unknown.

    Gaussian beams leave their scanner some mm wide and widen by an angle (`widening`, one sigma, rad).
    """
    return np.where(distance > 0.0, np.hypot(_EXIT, widening * distance), 0.0)


def _errors(u: Float, hidden: Bool, by_face: Float, blurred: Float) -> tuple[float, float]:
    """Returns by how much m the hidden beams of an edge err together, and the part of the footprint in it.

    The errors are one sigma each: of the depth of the face, and of the footprint.
    """
    if not hidden.any():
        return 0.0, 0.0
    near = hidden & (np.abs(u) < _STRIP)
    near = near if near.any() else hidden
    number = np.count_nonzero(near)
    footprints = _UNSURE * max(float(np.add.reduce(blurred[near]) / number), _EXIT)
    share = np.count_nonzero(hidden) / len(hidden)
    return float(np.hypot(np.add.reduce(np.abs(by_face[near])) / number, footprints)), footprints * share


def _far(u: Float, way: Float) -> float:
    """Returns the share of the beams (n,) right inside an edge that find nothing near behind it.

    way  (n,) depth of their points, 0 = the face, 1 = the frame
    """
    due = int(((u > -_STRIP) & (u < 0) & (way < 0.5)).sum())
    near = int(((u > 0) & (u < _STRIP) & (way >= 0.5) & (way < 1.5)).sum())
    return 1.0 - min(near / due, 1.0) if due >= FEW else 0.0


def _mixed(u: Float, way: Float, wide: Float, distance: Float) -> tuple[float, float, float]:
    """Returns the mixed echoes of an edge, how many there would be per m of footprint, and their range m."""
    between = (way > _MIXED[0]) & (way < _MIXED[1]) & (np.abs(u) < _ROUND)
    face = (u > -_STRIP) & (u < -_ROUND / 2) & (way < 0.5)
    if not face.any():
        return 0.0, 0.0, 0.0
    per_metre = float(face.sum()) / (_STRIP - _ROUND / 2)
    due = _QUANTILES * per_metre * float(wide[face].mean())
    return float(between.sum()), due, float(distance[face].mean())


def _face(near: CrossingBeams, side: Side, beside: Int, shared: SolidSide | None) -> SolidSide:
    """Returns the face that ends at a border: the foremost of the surfaces within a strip beside it.

    Where its own points do not tell it, the `shared` one is taken. The strip lies beside the border as the
    sensor sees it, for mixed echoes at an edge that hides what is behind lie far off it, but on the same
    lines of sight. So the strip depends on the face, and both are found in rounds.
    """
    solid = beside[(near.depth[beside] <= near.wall) & (near.depth[beside] > -FITTING)]
    if len(solid) < FEW:
        return shared or SolidSide(0.0, near.wall, len(solid))
    solid = solid[np.argsort(near.depth[solid])]
    depth = near.depth[solid]
    place, slope = (v[side.axis].take(solid) for v in (near.place, near.slope))
    hidden = side.sign * slope > 0
    front, y, beyond = depth, 0.0, bool(hidden.any())
    wide = max(_STRIP, 2.0 * typical_gap(np.sort(place)))
    for _ in range(_ROUNDS):
        u = side.sign * (place + slope * np.where(hidden, y, depth))
        front = _foremost(depth[u > _quantile(u, 0.97) - wide], near.wall)
        if len(front) < FEW:
            return shared or SolidSide(0.0, near.wall, len(front))
        before, y = y, float(np.add.reduce(front) / len(front))
        if y == before or not beyond:  # the next round would find the same
            break
    spread = np.sqrt(np.add.reduce((front - y) ** 2)) / len(front)
    return SolidSide(y, float(np.hypot(spread, _COMMON * near.wall / 3.0)), len(front))


def typical_gap(u: Float) -> float:
    """Returns the width m of the gap that a random place lies in among rising points u (n,) m.

    The columns of a raster are that far apart.
    """
    gap = np.diff(u)
    return float(gap @ gap / max(gap.sum(), 1e-9))


def _foremost(depth: Float, wall: float) -> Float:
    """Returns the rising depths (k,) m of the foremost surface of points (n,) m that is full enough.

    A few mixed echoes of the edge, or leaves before it, are not a surface.
    """
    number = np.searchsorted(depth, depth + wall) - np.arange(len(depth))
    if not len(number):
        return depth
    first = int(np.argmax(number >= _SURFACE * number.max()))
    middle = depth[first + number[first] // 2]
    return np.asarray(depth[np.abs(depth - middle) < wall])


def _quantile(values: Float, share: float) -> float:
    """Returns the quantile of values (n,), n > 1, share < 1; numpy's own takes longer than all else here."""
    at = share * (len(values) - 1)
    k = int(at)
    low, high = np.partition(values, (k, k + 1))[k : k + 2]
    return float(low + (at - k) * (high - low))
