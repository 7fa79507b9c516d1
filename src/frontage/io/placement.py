"""From the coordinates of a file to local metres: units, CRS, origin, and notes on what had to be assumed."""

from dataclasses import dataclass, replace

import numpy as np
from pyproj import CRS, Transformer

from frontage.errors import CrsError
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io import crs as systems
from frontage.io.transform import best_transformer, show, within
from frontage.model import WorldRef

_NEAR_M = 10_000.0  # coordinates this small lose nothing in float64 and keep their own origin
_ABSURD = 1e12  # file units: no coordinate is as large, not even in millimetres
_LEVER_M = 100.0  # distance at which a pose is sampled to rotate it with a curved transformation


@dataclass(frozen=True, eq=False)
class Placement:
    """How the coordinates of a file become local ones.

    world        the link between local coordinates and the world
    scale        (3,) units of the source CRS (or metres) per file unit
    offset       (3,) added after scaling, in units of the source CRS (or metres)
    transformer  source CRS to world CRS; None when they are the same
    flat         whether the transformer is horizontal only and leaves z as it is
    notes        sentences for the user about what was assumed
    """

    world: WorldRef
    scale: Float
    offset: Float
    transformer: Transformer | None = None
    flat: bool = True
    notes: tuple[str, ...] = ()

    def to_local(self, xyz: Float) -> Float:
        """Convert file coordinates (n, 3) to local metres (n, 3) float64.

        Raises CrsError when points lie outside the domain of the transformation.
        """
        p = np.asarray(xyz, np.float64)
        if self.transformer is None:
            return p * self.scale + (self.offset - self.world.origin)
        p = p * self.scale + self.offset
        z = p[:, 2]
        if self.flat:
            x, y = self.transformer.transform(p[:, 0], p[:, 1])
        else:
            x, y, z = self.transformer.transform(p[:, 0], p[:, 1], z)
        out = np.column_stack([x, y, z])
        if (~np.isfinite(out) & np.isfinite(p)).any():
            raise CrsError(
                f"coordinates such as {show(p[~np.isfinite(out).all(1)][0])} lie outside the area in which "
                f"their CRS can be transformed; check the scan's crs",
                code="I204",
            )
        return out - self.world.origin

    def points_of(self, pose: Rigid3, xyz: Float) -> Float:
        """Convert points (n, 3) from a scanner's frame, at `pose` in file coordinates, to local metres."""
        if self.transformer is None and np.all(self.scale == 1.0):
            return np.asarray(xyz, np.float64) @ pose.R.T + (pose.t + (self.offset - self.world.origin))
        return self.to_local(pose.apply(xyz))

    def pose_of(self, pose: Rigid3) -> Rigid3:
        """Convert a pose in file coordinates to local ones; a curved transformation also rotates it."""
        if self.transformer is None:
            return Rigid3("local", pose.frm, pose.R, self.to_local(pose.t[None])[0])
        probes = pose.t + _LEVER_M * np.vstack([np.zeros(3), pose.R.T])
        local = self.to_local(probes)
        U, _, Vt = np.linalg.svd((local[1:] - local[0]).T / _LEVER_M)
        return Rigid3("local", pose.frm, U @ Vt, local[0])


@dataclass(frozen=True, eq=False)
class PlacementRequest:
    """What the caller asks of the coordinates of one file.

    name    the file, for messages
    world   the world of the run, when it is decided already
    target  the CRS that the user asks for
    crs     the CRS of the file's coordinates; it overrides what the file states
    units   of the file's coordinates ("m", "cm", "mm", "ft", "us-ft"); it overrides what the file states
    offset  (x, y, z) m, added to the coordinates of the file
    """

    name: str
    world: WorldRef | None = None
    target: str | None = None
    crs: str | None = None
    units: str | None = None
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def place(self, file_crs: CRS | None, sample: Array) -> Placement:
        """Decide the placement from the CRS that the file states and some of its points (n, 3), n > 0.

        Raises CrsError when the file has no CRS and the other data has one, or the other way round, or when
        no transformation is known.
        """
        points = np.asarray(sample, np.float64)
        points = points[(np.abs(points) < _ABSURD).all(1)]  # False for NaN
        points = points if len(points) else np.zeros((1, 3))
        source = systems.parse_crs(self.crs, self.name) if self.crs else file_crs
        notes: list[str] = []
        source = self._guess(source, points + self.offset, notes)
        target = self._target(source, points, notes)
        if source is None or target is None:
            return self._engineering(points, notes)
        return _placement(self, source, target, points, notes)

    def _guess(self, source: CRS | None, points: Float, notes: list[str]) -> CRS | None:
        """The file's CRS; where it states none, geocentric by magnitude, else the project's where it fits."""
        if source is not None:
            return source
        if systems.looks_geocentric(points):
            notes.append(
                f"{self.name}: states no CRS, but its coordinates are geocentric and were taken as EPSG:4978"
            )
            return CRS.from_epsg(4978)
        if self.target:
            target = systems.parse_crs(self.target, "project")
            if within(target, points * systems.METRE_PER[self.units or "m"]):
                notes.append(f"{self.name}: no CRS stated: taken to be in the project's, {self.target}")
                return target
        return None

    def _target(self, source: CRS | None, points: Float, notes: list[str]) -> CRS | None:
        """The world CRS, None without any. Raises CrsError when only part of the data has a CRS."""
        text = self.world.crs if self.world is not None else self.target
        if source is None and text is not None:
            raise CrsError(
                f'{self.name}: has no CRS, but the project is in {text}; state it with crs = "EPSG:..."',
                code="I202",
            )
        if source is not None and self.world is not None and self.world.crs is None:
            raise CrsError(
                f"{self.name}: is in {source.name}, but other data has no CRS; state crs for that data",
                code="I202",
            )
        if source is None:
            return None
        if text is None:
            return _default_target(source, points, notes, self)
        target = systems.parse_crs(text, "project")
        if systems.is_world(target):
            return target
        twin = systems.metric_twin(target)
        if twin is None:
            raise CrsError(
                f"{text}: is not a projected east-north CRS; name one in metres such as EPSG:25832",
                code="I203",
            )
        notes.append(f"{text} is not in metres; the same projection in metres was used instead")
        return twin

    def _engineering(self, points: Float, notes: list[str]) -> Placement:
        """The placement in local engineering coordinates, where no data has a CRS."""
        unit = systems.METRE_PER[self.units or "m"]
        if not any("no CRS" in n for n in notes):
            notes.append(
                f"{self.name}: no CRS: local engineering coordinates"
                + ("" if self.units else ", taken as metres")
            )
        placed = points * unit + self.offset
        world = self.world or WorldRef(_origin(placed), None)
        return Placement(world, np.full(3, unit), np.array(self.offset), notes=tuple(notes))


def _default_target(source: CRS, points: Float, notes: list[str], wanted: PlacementRequest) -> CRS:
    """The world CRS where none is asked for: the file's own in metres, else the UTM zone of the data."""
    if systems.is_world(source):
        # A 3-D projected CRS has ellipsoidal heights; its 2-D part is the same projection.
        return source if source.is_compound else systems.horizontal(source)
    twin = systems.metric_twin(source)
    if twin is not None:
        notes.append(f"{wanted.name}: {source.name} is not in metres; its coordinates were converted")
        return twin
    to_degrees = Transformer.from_crs(source, "EPSG:4979", always_xy=True)
    lon, lat = to_degrees.transform(*np.median(points + wanted.offset, axis=0))[:2]
    if not (np.isfinite(lon) and np.isfinite(lat)):
        raise CrsError(
            f"{wanted.name}: coordinates such as {show(points[0])} do not fit {source.name}", code="I204"
        )
    zone = systems.utm_for(source, float(lon), float(lat))
    code = systems.crs_text(zone)
    notes.append(f"{wanted.name}: {source.name} was transformed to {zone.name} ({code})")
    return zone


def _placement(
    wanted: PlacementRequest, source: CRS, target: CRS, points: Float, notes: list[str]
) -> Placement:
    """The placement between two known systems: units and transformer."""
    flat = _heights_stay(source, target)
    scale, moved = (_plan_only if flat else _in_space)(wanted, source, target, points, notes)
    unplaced = WorldRef(np.zeros(3, np.int64), systems.crs_text(target))
    offset = np.asarray(wanted.offset, np.float64)
    return _anchored(Placement(unplaced, scale, offset, moved, flat, tuple(notes)), wanted.world, points)


def _heights_stay(source: CRS, target: CRS) -> bool:
    """Whether heights mean the same in both systems, as far as is known: then only the plan moves."""
    up_from, up_to = systems.vertical(source), systems.vertical(target)
    spatial = source.is_geocentric or (len(source.axis_info) == 3 and not source.is_compound)
    if spatial and up_to is not None:
        return False
    alike = up_from is None or up_to is None or up_from.equals(up_to)
    return (alike and not source.is_geocentric) or _same_but_unit(up_from, up_to)


def _plan_scale(wanted: PlacementRequest, source: CRS) -> float:
    """Units of the plan of the source CRS per file unit."""
    flat = systems.horizontal(source)
    if wanted.units is None or flat.is_geographic:
        return 1.0
    return systems.METRE_PER[wanted.units] / systems.unit_of(flat)


def _plan_only(
    wanted: PlacementRequest, source: CRS, target: CRS, points: Float, notes: list[str]
) -> tuple[Float, Transformer | None]:
    """Scale (3,) and transformer of the plan; heights are only scaled to metres."""
    flat_from, flat_to = systems.horizontal(source), systems.horizontal(target)
    up_from, up_to = systems.vertical(source), systems.vertical(target)
    unit = systems.METRE_PER[wanted.units] if wanted.units else None
    plan, z_unit = _plan_scale(wanted, source), unit or _height_unit(source, up_from)
    scale = np.array([plan, plan, z_unit])
    moved = None
    if not flat_from.equals(flat_to, ignore_axis_order=True):
        moved = best_transformer(wanted.name, flat_from, flat_to, points * scale + wanted.offset, notes)
    if up_from is None and up_to is not None:
        notes.append(f"{wanted.name}: its heights have no datum and were taken to be in {up_to.name}")
    if unit is None and abs(z_unit - 1.0) > 1e-12 and up_from is None:
        notes.append(f"{wanted.name}: its heights were taken to be in the unit of the plan, {z_unit:.9g} m")
    return scale, moved


def _in_space(
    wanted: PlacementRequest, source: CRS, target: CRS, points: Float, notes: list[str]
) -> tuple[Float, Transformer]:
    """Scale (3,) and transformer of plan and heights together."""
    up_from, up_to = systems.vertical(source), systems.vertical(target)
    plan = z_scale = _plan_scale(wanted, source)
    if up_from is not None:
        up_unit = systems.unit_of(up_from)
        z_scale = (systems.METRE_PER[wanted.units] if wanted.units else up_unit) / up_unit
    scale = np.array([plan, plan, z_scale])
    spatial_to = target if up_to is not None else systems.horizontal(target).to_3d()
    moved = best_transformer(wanted.name, source, spatial_to, points * scale + wanted.offset, notes)
    if up_to is None:
        notes.append(f"{wanted.name}: its heights are above the ellipsoid")
    return scale, moved


def _anchored(trial: Placement, world: WorldRef | None, points: Float) -> Placement:
    """The placement in `world`, or in a new one whose origin lies near the points (n, 3)."""
    return replace(trial, world=world or WorldRef(_origin(trial.to_local(points)), trial.world.crs))


def _same_but_unit(a: CRS | None, b: CRS | None) -> bool:
    """Whether two vertical systems share their datum, whatever their units."""
    if a is None or b is None or a.datum is None or b.datum is None:
        return False
    return a.datum.name == b.datum.name and a.axis_info[0].direction == b.axis_info[0].direction == "up"


def _height_unit(source: CRS, upright: CRS | None) -> float:
    """Metres per unit of z: that of the vertical axis where there is one, else that of the plan."""
    if upright is not None:
        return systems.unit_of(upright)
    axes = source.axis_info
    return (
        float(axes[2].unit_conversion_factor)
        if len(axes) == 3
        else systems.unit_of(systems.horizontal(source))
    )


def _origin(points: Float) -> Array:
    """A whole-metre origin for points (n, 3) m: zero for small coordinates, else the median of the data."""
    if np.abs(points).max() < _NEAR_M:
        return np.zeros(3, np.int64)
    return np.floor(np.median(points, axis=0)).astype(np.int64)
