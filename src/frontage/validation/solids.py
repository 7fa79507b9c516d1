"""Level 4: the shells of one solid. Codes 401 to 405."""

import itertools
from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Finding
from frontage.validation.closed_surface import TriangulatedShell
from frontage.validation.complement import complement_components
from frontage.validation.pieces import (
    INSIDE,
    OPPOSITE,
    OUTSIDE,
    SAME,
    ClassifiedPieces,
    classify_pieces,
)
from frontage.validation.shells import volume

_ON = (SAME, OPPOSITE)
_MOST_PAIRS = 100  # of shells that are told to be wrong: more would take long and tell nothing new

_Verdict = tuple[int, str, Float]  # code, message and the place (3,) m


def check_solid(shells: Sequence[TriangulatedShell]) -> list[Finding]:
    """Checks the shells of a solid, the outer one first, each of them valid in itself.

    Shells may touch in points and along lines, but not share a part of a face.
    """
    findings = _wrong_orientation(shells)
    surfaces = [s.surface for s in shells]
    in_pairs = []
    for i, j in itertools.combinations(range(len(surfaces)), 2):
        one, other = classify_pieces(surfaces[i], surfaces[j]), classify_pieces(surfaces[j], surfaces[i])
        verdict = _outer_and_inner(one, other) if i == 0 else _two_inner(one, other)
        if verdict is not None:
            code, text, at = verdict
            location = shells[0].mesh.location(at)
            in_pairs.append(Finding(code, text, f"shell={i}&shell={j}", "", location))
        if len(in_pairs) >= _MOST_PAIRS:
            break
    if not in_pairs and len(surfaces) > 1:
        return findings + _disconnected_interior(shells)
    return findings + in_pairs


def _wrong_orientation(shells: Sequence[TriangulatedShell]) -> list[Finding]:
    """405: the outer shell must look outwards, the others into their voids."""
    findings = []
    for k, shell in enumerate(shells):
        mesh, ids = shell.mesh, shell.triangles.ids
        signed = volume(mesh, ids)
        if (signed <= 0) if k == 0 else (signed >= 0):
            text = "all faces look inwards" if k == 0 else "the faces of an inner shell look out of its void"
            middle = mesh.location(mesh.xyz[ids].mean((0, 1)))
            findings.append(Finding(405, text, f"shell={k}", "", middle, qie=308 if k == 0 else None))
    return findings


def _disconnected_interior(shells: Sequence[TriangulatedShell]) -> list[Finding]:
    """404: the shells of the voids touch so that they divide the interior."""
    surfaces = [s.surface for s in shells]
    count = complement_components(surfaces)
    if count <= len(surfaces) + 1:
        return []
    text = f"the voids cut the interior into {count - len(surfaces)} separate pieces"
    middle = shells[0].mesh.location(surfaces[0].corners.mean((0, 1)))
    return [Finding(404, text, "", "", middle)]


def _outer_and_inner(outer: ClassifiedPieces, inner: ClassifiedPieces) -> _Verdict | None:
    """Returns what is wrong between the outer shell and an inner one."""
    if inner.has(*_ON):
        if np.isin(inner.state, _ON).all() and np.isin(outer.state, _ON).all():
            return 402, "the inner shell is the same as the outer one", inner.widest(*_ON)
        return 401, "the inner and the outer shell share a part of a face", inner.widest(*_ON)
    if inner.has(INSIDE) and inner.has(OUTSIDE):
        return 401, "the inner shell passes through the outer one", inner.widest(OUTSIDE)
    if outer.has(INSIDE):
        if inner.has(INSIDE):
            return 401, "the shells pass through each other", outer.widest(INSIDE)
        return 403, "the inner shell surrounds the outer one", inner.widest(OUTSIDE)
    if inner.has(OUTSIDE):
        return 403, "the inner shell lies outside of the outer one", inner.widest(OUTSIDE)
    return None


def _two_inner(one: ClassifiedPieces, other: ClassifiedPieces) -> _Verdict | None:
    """Returns what is wrong between two inner shells."""
    if one.has(*_ON):
        if np.isin(one.state, _ON).all() and np.isin(other.state, _ON).all():
            return 402, "two inner shells are the same", one.widest(*_ON)
        return 401, "two inner shells share a part of a face", one.widest(*_ON)
    if one.has(INSIDE) or other.has(INSIDE):
        overlapping = one if one.has(INSIDE) else other
        return 401, "the voids of two inner shells overlap", overlapping.widest(INSIDE)
    return None
