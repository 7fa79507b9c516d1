"""The order of the standard: ring, polygon, shell, solid, composite, building.

A level is only looked at when the ones below it hold, so that one defect is not reported five times.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from frontage.model import Feature, Finding, Polygons, Shape, Solid
from frontage.validation.bodies import Shell, check_solid
from frontage.validation.composites import Body, check_composite, check_parts
from frontage.validation.geometry.mesh import Mesh, weld
from frontage.validation.polygons import Triangles, check_polygons
from frontage.validation.rings import check_rings
from frontage.validation.rooms import check_rooms
from frontage.validation.shells import check_shell
from frontage.validation.tolerances import Tolerances

_CLOSED = ("Solid", "MultiSolid", "CompositeSolid")
_DEFAULT = Tolerances()
_SOLID_STEP = 1e-4  # m: the grid of `Solid`


def validate(solid: Solid, tolerances: Tolerances = _DEFAULT) -> tuple[Finding, ...]:
    """All findings on a solid of Frontage's own, in its whole coordinates; none: it is valid.

    Locations are in the world.
    """
    local = solid.vertices * _SOLID_STEP
    faces = Polygons.of([[local[list(r)] for r in (f.ring, *f.holes)] for f in solid.faces])
    shape = Shape("Solid", ((faces,),), solid.lod)
    feature = Feature(solid.building, "Building", (shape,))
    findings = validate_feature(feature, tolerances, _SOLID_STEP)
    return tuple(_moved(f, solid.origin.tolist()) for f in findings)


def _moved(finding: Finding, origin: Sequence[int]) -> Finding:
    if finding.location is None:
        return finding
    x, y, z = (v + o for v, o in zip(finding.location, origin, strict=True))
    return replace(finding, location=(x, y, z))


def validate_shape(shape: Shape, tolerances: Tolerances = _DEFAULT) -> tuple[Finding, ...]:
    """All findings on one geometry."""
    return validate_feature(Feature("", "", (shape,)), tolerances)


def validate_feature(
    feature: Feature, tolerances: Tolerances = _DEFAULT, quantum: float | None = None
) -> tuple[Finding, ...]:
    """All findings on the geometries of a feature and its parts, and on their solids among each other.

    `quantum` (m): the coordinates are whole multiples of it.
    """
    everything = list(_shapes(feature))
    surfaces = [s for _, _, shape in everything for solid in shape.solids for s in solid]
    meshes = iter(weld(surfaces, tolerances.snap, quantum))
    findings: list[Finding] = []
    bodies: list[tuple[Body, tuple[str, int], str]] = []
    for owner, number, shape in everything:
        shells = [tuple(next(meshes) for _ in solid) for solid in shape.solids]
        found, valid = _check_shape(shape, shells, tolerances)
        name = f"geometry={number}" + (f"({shape.name})" if shape.name else "")
        findings += [
            replace(f, feature=owner, where="|".join(x for x in (name, f.where) if x)) for f in found
        ]
        bodies += [(replace(b, name=_join(owner, name, b.name)), (owner, number), shape.lod) for b in valid]
    findings += [replace(f, feature=feature.id) for f in _among(feature, bodies, tolerances)]
    return tuple(findings)


def _among(
    feature: Feature, bodies: Sequence[tuple[Body, tuple[str, int], str]], tolerances: Tolerances
) -> list[Finding]:
    """Findings on the valid solids of a feature among each other: (solid, owner and geometry, lod)."""
    if feature.graph is not None:
        owners = [group[0] for _, group, _ in bodies]
        return check_rooms(feature.graph, [body for body, _, _ in bodies], owners, tolerances)
    findings = []
    for lod in sorted({lod for _, _, lod in bodies}):
        own = [(body, group) for body, group, level in bodies if level == lod]
        findings += check_parts([b for b, _ in own], [g for _, g in own], tolerances)
    return findings


def _shapes(feature: Feature) -> Iterator[tuple[str, int, Shape]]:
    """Every geometry of a feature and its parts, with its owner and number there."""
    for number, shape in enumerate(feature.shapes):
        yield feature.id, number, shape
    for part in feature.parts:
        yield from _shapes(part)


def _join(*names: str) -> str:
    return "|".join(n for n in names if n)


def _check_shape(
    shape: Shape, solids: Sequence[tuple[Mesh, ...]], tolerances: Tolerances
) -> tuple[list[Finding], list[Body]]:
    """Findings on one geometry, and its solids that are valid."""
    findings: list[Finding] = []
    bodies: list[Body] = []
    if not solids:
        findings.append(Finding(902, f"a {shape.kind} without anything in it"))
    many = len(solids) > 1 or shape.kind in ("MultiSolid", "CompositeSolid")
    for number, meshes in enumerate(solids):
        name = f"solid={number}" if many else ""
        found, body = _check_solid(shape.kind, meshes, name, tolerances)
        findings += [replace(f, where=_join(name, f.where)) for f in found]
        bodies += [body] if body is not None else []
    if shape.kind == "CompositeSolid" and not findings:
        findings += check_composite(bodies, tolerances)
    return findings, bodies if shape.kind in _CLOSED else []


def _check_solid(
    kind: str, meshes: Sequence[Mesh], name: str, tolerances: Tolerances
) -> tuple[list[Finding], Body | None]:
    """Findings on the shells of one solid, or on one surface; and the body if there are none."""
    findings: list[Finding] = []
    shells: list[Shell] = []
    if not meshes:
        findings.append(Finding(902, "a solid without shells"))
    for number, mesh in enumerate(meshes):
        shell = f"shell={number}" if kind in _CLOSED else ""
        found, triangles = _check_faces(kind, mesh, number > 0, tolerances)
        findings += [replace(f, where=_join(shell, f.where)) for f in found]
        shells.append((mesh, triangles))
    if kind not in _CLOSED or findings:
        return findings, None
    findings += check_solid(shells)
    return findings, None if findings else Body(tuple(shells), name)


def _check_faces(
    kind: str, mesh: Mesh, inner: bool, tolerances: Tolerances
) -> tuple[list[Finding], Triangles]:
    """Rings, then polygons, then the shell."""
    number = len(mesh.faces) - 1
    empty = Triangles(*(np.zeros(s, np.int64) for s in ((0, 3), 0, (0, 2), 0)))
    if number == 0:
        return [Finding(902, "no faces")], empty
    findings, good = check_rings(mesh)
    in_faces, triangles = check_polygons(mesh, good, tolerances)
    findings += in_faces
    if kind != "MultiSurface" and not findings:
        findings += check_shell(mesh, triangles, tolerances, kind in _CLOSED, inner)
    return findings, triangles
