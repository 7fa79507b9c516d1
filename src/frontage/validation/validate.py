"""Validates geometries level by level, as in ISO 19107.

1 rings, 2 polygons, 3 shells, 4 solids, 5 composite solids, 6 buildings, 7 indoor models. A level is checked
only if the levels below it hold, so that one defect is not reported several times.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.model import Feature, Finding, Polygons, Shape, Solid
from frontage.validation.closed_surface import TriangulatedShell, ValidSolid
from frontage.validation.composites import check_composite, check_parts, overlaps
from frontage.validation.geometry.mesh import Mesh, weld
from frontage.validation.geometry.triangulate import Triangles
from frontage.validation.indoor import check_indoor
from frontage.validation.polygons import check_polygons
from frontage.validation.rings import check_rings
from frontage.validation.shells import check_shell
from frontage.validation.solids import check_solid
from frontage.validation.tolerances import Tolerances

_CLOSED_KINDS = ("Solid", "MultiSolid", "CompositeSolid")
_DEFAULT = Tolerances()
_SOLID_STEP_M = 1e-4  # the grid of `Solid`


def validate(solid: Solid, tolerances: Tolerances = _DEFAULT) -> tuple[Finding, ...]:
    """Validates one of Frontage's integer solids; returns no findings if it is valid.

    The locations of findings are in world coordinates (m).
    """
    local = solid.vertices * _SOLID_STEP_M
    faces = Polygons.of([[local[list(r)] for r in (f.ring, *f.holes)] for f in solid.faces])
    feature = Feature(solid.building, "Building", (Shape("Solid", ((faces,),), solid.lod),))
    findings = validate_feature(feature, tolerances, _SOLID_STEP_M)
    return tuple(_in_world(f, solid.origin.tolist()) for f in findings)


def validate_shape(shape: Shape, tolerances: Tolerances = _DEFAULT) -> tuple[Finding, ...]:
    """Validates one geometry."""
    return validate_feature(Feature("", "", (shape,)), tolerances)


def validate_feature(
    feature: Feature, tolerances: Tolerances = _DEFAULT, quantum: float | None = None
) -> tuple[Finding, ...]:
    """Validates the geometries of a feature and its parts, and its solids together.

    `quantum` (m) is given if the coordinates are known to be whole multiples of it.
    """
    findings, solids = _check_each(feature, tolerances, quantum)
    findings += [replace(f, feature=feature.id) for f in _check_together(feature, solids, tolerances)]
    return tuple(findings)


def _check_each(
    feature: Feature, tolerances: Tolerances, quantum: float | None
) -> tuple[list[Finding], list["_OwnedSolid"]]:
    """Levels 1 to 5: every geometry of a feature by itself; returns the solids that are valid."""
    geometries = list(_geometries(feature))
    surfaces = [s for g in geometries for solid in g.shape.solids for s in solid]
    groups = [k for k, g in enumerate(geometries) for solid in g.shape.solids for _ in solid]
    meshes = iter(weld(surfaces, tolerances.snap, quantum, groups))
    findings: list[Finding] = []
    solids: list[_OwnedSolid] = []
    for g in geometries:
        own_meshes = [[next(meshes) for _ in solid] for solid in g.shape.solids]
        found, valid = _check_geometry(g.shape, own_meshes, tolerances)
        findings += [replace(f, feature=g.owner, where=_joined(g.name, f.where)) for f in found]
        solids += [_OwnedSolid(g, replace(s, name=_joined(g.owner, g.name, s.name))) for s in valid]
    return findings, solids


def overlapping(solids: Sequence[Solid]) -> list[tuple[int, int, float]]:
    """Returns the pairs (i < j) of valid solids that reach into each other, and how far (m).

    The solids are integer solids with a common origin.
    """
    parts = []
    for k, solid in enumerate(solids):
        local = solid.vertices * _SOLID_STEP_M
        faces = Polygons.of([[local[list(r)] for r in (f.ring, *f.holes)] for f in solid.faces])
        parts.append(Feature(str(k), "", (Shape("Solid", ((faces,),)),)))
    _, owned = _check_each(Feature("", "", (), tuple(parts)), _DEFAULT, _SOLID_STEP_M)
    valid = [o.solid for o in owned]
    number = [int(o.geometry.owner) for o in owned]
    return [(number[i], number[j], r.overlap) for i, j, r in overlaps(valid, number, _DEFAULT)]


@dataclass(frozen=True, eq=False)
class _Geometry:
    """A geometry, the id of the feature or part that it belongs to, and its number there."""

    owner: str
    number: int
    shape: Shape

    @property
    def name(self) -> str:
        """How findings name it."""
        return f"geometry={self.number}" + (f"({self.shape.name})" if self.shape.name else "")


@dataclass(frozen=True, eq=False)
class _OwnedSolid:
    """A valid solid and the geometry that it belongs to."""

    geometry: _Geometry
    solid: ValidSolid


def _check_surface(
    kind: str, mesh: Mesh, inner: bool, tolerances: Tolerances
) -> tuple[list[Finding], Triangles]:
    """Levels 1 to 3: the rings, polygons and shell of one surface; `inner` for a shell around a void."""
    if len(mesh.faces) == 1:
        return [Finding(902, "no faces")], Triangles.none()
    findings, sound = check_rings(mesh)
    if any(np.diff(offsets).min() == 0 for offsets in (mesh.rings, mesh.faces)):
        return findings, Triangles.none()  # a face or a ring of nothing has no plane
    in_polygons, triangles = check_polygons(mesh, sound, tolerances)
    findings += in_polygons
    if kind != "MultiSurface" and not findings:
        findings += check_shell(mesh, triangles, tolerances, kind in _CLOSED_KINDS, inner)
    return findings, triangles


def _check_solid(
    kind: str, meshes: Sequence[Mesh], name: str, tolerances: Tolerances
) -> tuple[list[Finding], ValidSolid | None]:
    """Level 4: the shells of one solid; returns the solid if it is valid. Also takes a single surface."""
    findings: list[Finding] = []
    shells: list[TriangulatedShell] = []
    if not meshes:
        findings.append(Finding(902, "a solid without shells"))
    for number, mesh in enumerate(meshes):
        shell = f"shell={number}" if kind in _CLOSED_KINDS else ""
        found, triangles = _check_surface(kind, mesh, number > 0, tolerances)
        findings += [replace(f, where=_joined(shell, f.where)) for f in found]
        shells.append(TriangulatedShell(mesh, triangles))
    if kind not in _CLOSED_KINDS or findings:
        return findings, None
    findings += check_solid(shells)
    return findings, None if findings else ValidSolid(tuple(shells), name)


def _check_geometry(
    shape: Shape, solids: Sequence[Sequence[Mesh]], tolerances: Tolerances
) -> tuple[list[Finding], list[ValidSolid]]:
    """Level 5: the solids of one geometry; returns those that are valid."""
    findings: list[Finding] = []
    valid: list[ValidSolid] = []
    if not solids:
        findings.append(Finding(902, f"a {shape.kind} without any content"))
    many = len(solids) > 1 or shape.kind in ("MultiSolid", "CompositeSolid")
    for number, meshes in enumerate(solids):
        name = f"solid={number}" if many else ""
        found, solid = _check_solid(shape.kind, meshes, name, tolerances)
        findings += [replace(f, where=_joined(name, f.where)) for f in found]
        valid += [solid] if solid is not None else []
    if shape.kind == "CompositeSolid" and not findings:
        findings += check_composite(valid, tolerances)
    return findings, valid if shape.kind in _CLOSED_KINDS else []


def _check_together(feature: Feature, owned: Sequence[_OwnedSolid], tolerances: Tolerances) -> list[Finding]:
    """Levels 6 and 7: the valid solids of a feature together, by level of detail or with the graph."""
    if feature.graph is not None:
        owners = [o.geometry.owner for o in owned]
        return check_indoor(feature.graph, [o.solid for o in owned], owners, tolerances)
    findings = []
    for lod in sorted({o.geometry.shape.lod for o in owned}):
        own = [o for o in owned if o.geometry.shape.lod == lod]
        groups = [(o.geometry.owner, o.geometry.number) for o in own]
        findings += check_parts([o.solid for o in own], groups, tolerances)
    return findings


def _geometries(feature: Feature) -> Iterator[_Geometry]:
    """Yields the geometries of a feature and its parts."""
    for number, shape in enumerate(feature.shapes):
        yield _Geometry(feature.id, number, shape)
    for part in feature.parts:
        yield from _geometries(part)


def _in_world(finding: Finding, origin: Sequence[int]) -> Finding:
    """Moves the location of a finding by the origin (m) of its solid."""
    if finding.location is None:
        return finding
    x, y, z = (v + o for v, o in zip(finding.location, origin, strict=True))
    return replace(finding, location=(x, y, z))


def _joined(*names: str) -> str:
    return "|".join(n for n in names if n)
