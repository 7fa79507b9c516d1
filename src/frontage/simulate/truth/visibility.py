"""Visibility: the share of every opening and facade that has a free line of sight to a sensor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.ring import at_depth
from frontage.model import Photo
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, OpeningPlan, Scene

_ACROSS = 8  # samples across the width of an opening, and across its height
_STEP_M = 0.5  # between samples of a facade
_BEFORE_M = 0.01  # distance of samples in front of the wall
_SLACK_M = 0.03  # a hit this close to a sample is on the surroundings of the sample itself
_REACH_M = 60.0  # from further away nothing is resolved
_GRAZING_COS = np.cos(np.radians(80.0))  # walls that are seen at a more grazing angle are not resolved
_TRACK_STEP_M = 1.0  # between the positions of a track that are used

Shares = dict[str, float]
"""Share 0..1 by the name of the sensors: "stations", "drive", "photos", and "any"."""


@dataclass(frozen=True, eq=False)
class ScannerView:
    """A scanner's position and field of view.

    place             (3,) m local
    forward, field    direction (3,) of the middle of the horizontal field, and its angle, rad
    lowest, highest   elevations, rad
    """

    place: Float
    forward: Float
    field: float
    lowest: float
    highest: float

    def within(self, rays: Float) -> Bool:
        """Return which rays (n, 3) from the scanner lie within its field of view."""
        flat = np.hypot(rays[:, 0], rays[:, 1])
        elevation = np.arctan2(rays[:, 2], flat)
        cosine = (rays[:, :2] @ self.forward[:2]) / np.maximum(flat * np.hypot(*self.forward[:2]), 1e-12)
        ahead = np.arccos(np.clip(cosine, -1, 1)) <= self.field / 2
        return np.asarray(ahead & (elevation >= self.lowest) & (elevation <= self.highest))


@dataclass(frozen=True, eq=False)
class Visibility:
    """Visible shares by index: of facades (house, facade), of openings (house, facade, opening)."""

    facades: Mapping[tuple[int, int], Shares]
    openings: Mapping[tuple[int, int, int], Shares]


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points (n, 3) m local just in front of the walls, and the outward normals (n, 3) of the walls.

    key     (n, 3) int64: house, facade and opening that each belongs to (-1 = the facade itself)
    """

    xyz: Float
    outward: Float
    key: Int


def visibility(
    scene: Scene, tracer: Tracer, stations: Sequence[ScannerView], track: Float, photos: Sequence[Photo]
) -> Visibility:
    """Return which share of the walls and openings the sensors see, from rays to samples of them.

    track (m, 3) m local are the positions of a vehicle, in order. A photo sees what lies in its picture, a
    station what lies in its field of view. An opening is not hidden by its own frame, panes and shutters, but
    by anything else in front of it.
    """
    samples = _samples(scene)
    owner = np.array([(s.house, s.facade, s.opening) for s in scene.surfaces], np.int64).reshape(-1, 3)
    seen: dict[str, Bool] = {}
    xyz, everything = samples.xyz, np.ones(len(samples.xyz), np.bool_)
    eyes = {
        "stations": [(e.place, e.within(xyz - e.place)) for e in stations],
        "drive": [(place, everything) for place in _thinned(track)],
        "photos": [(p.pose.t, _pictured(p, xyz)) for p in photos],
    }
    for name, places in eyes.items():
        if places:
            seen[name] = ~everything
            for place, among in places:
                hidden = among & ~seen[name]
                seen[name] |= _visible(scene, tracer, samples, owner, viewpoint=place, among=hidden)
    any_sensor = np.any(list(seen.values()), axis=0) if seen else np.zeros(len(samples.xyz), np.bool_)
    return _shares(samples.key, seen | {"any": any_sensor})


def _shares(key: Int, seen: Mapping[str, Bool]) -> Visibility:
    """Returns the share of the samples of each facade and opening that were seen."""
    names, group = np.unique(key, axis=0, return_inverse=True)
    count = np.bincount(group.ravel())
    share = {k: np.bincount(group.ravel(), v) / count for k, v in seen.items()}
    facades: dict[tuple[int, int], Shares] = {}
    openings: dict[tuple[int, int, int], Shares] = {}
    for number, (house, facade, opening) in enumerate(names.tolist()):
        row = {k: round(float(v[number]), 4) for k, v in share.items()}
        if opening < 0:
            facades[house, facade] = row
        else:
            openings[house, facade, opening] = row
    return Visibility(facades, openings)


def _samples(scene: Scene) -> _Samples:
    xyz, outward, key = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty((0, 3), np.int64)]
    for h, house in enumerate(scene.houses):
        for f, facade in enumerate(house.facades):
            parts = [(-1, _wall_samples(facade))]
            parts += [(o, _opening_samples(opening)) for o, opening in enumerate(facade.openings)]
            for o, points in parts:
                xyz.append(facade.local_from_facade.apply(points))
                outward.append(np.broadcast_to(-facade.local_from_facade.R[:, 1], points.shape))
                key.append(np.broadcast_to(np.array([h, f, o]), points.shape))
    return _Samples(np.concatenate(xyz), np.concatenate(outward), np.concatenate(key))


def _opening_samples(opening: OpeningPlan) -> Float:
    """Returns a raster of points (n, 3) in an opening, facade frame."""
    xz = _inside(opening.ring, *(np.ptp(opening.ring, axis=0) / _ACROSS))
    return at_depth(xz, opening.wall_y - _BEFORE_M)


def _wall_samples(facade: FacadePlan) -> Float:
    """Returns a raster of points (n, 3) on the main plane within the outline, facade frame."""
    xz = _inside(facade.outline, _STEP_M, _STEP_M)
    return at_depth(xz, -_BEFORE_M)


def _inside(ring: Float, dx: float, dz: float) -> Float:
    """Returns the centres (n, 2) of raster cells in a ring, or some point within it if there are none."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    x, z = np.meshgrid(np.arange(x0 + dx / 2, x1, dx), np.arange(z0 + dz / 2, z1, dz))
    polygon = shapely.make_valid(shapely.Polygon(ring))
    inside = shapely.contains_xy(polygon, x.ravel(), z.ravel())
    if not inside.any():
        return np.asarray(shapely.get_coordinates(shapely.point_on_surface(polygon)), np.float64)
    return np.asarray(np.column_stack([x.ravel(), z.ravel()])[inside])


def _visible(
    scene: Scene, tracer: Tracer, samples: _Samples, owner: Int, *, viewpoint: Float, among: Bool
) -> Bool:
    """Returns which samples `among` (n,) are visible from `viewpoint` (3,): near, not grazing, not hidden.

    owner (s, 3) is house, facade and opening of every surface.
    """
    ray = samples.xyz - viewpoint
    distance = np.linalg.norm(ray, axis=1)
    slant = -(ray * samples.outward).sum(1) / np.maximum(distance, 1e-9)
    rows = np.flatnonzero(among & (distance < _REACH_M) & (slant > _GRAZING_COS))
    seen = np.zeros(len(ray), np.bool_)
    hits = tracer.first_hit(viewpoint, ray[rows] / distance[rows, None])
    before = hits.distance < distance[rows] - _SLACK_M
    own = np.zeros(len(rows), np.bool_)
    met = np.flatnonzero(before)
    surface = scene.mesh.surface[hits.triangle[met]]
    own[met] = (owner[surface] == samples.key[rows[met]]).all(1) & (samples.key[rows[met], 2] >= 0)
    seen[rows] = ~before | own
    return seen


def _pictured(photo: Photo, xyz: Float) -> Bool:
    """Returns which points fall into the picture."""
    with np.errstate(invalid="ignore"):
        uv = photo.project(xyz)
        size = np.array([photo.camera.width, photo.camera.height])
        return np.asarray(((uv >= 0) & (uv < size)).all(1))


def _thinned(track: Float) -> Float:
    """Returns positions that are about a metre apart."""
    if not len(track):
        return track
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(track, axis=0), axis=1))])
    _, first = np.unique(np.floor(arc / _TRACK_STEP_M), return_index=True)
    return track[first]
