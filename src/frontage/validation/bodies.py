"""Level 4: the shells of one solid. Codes 401 to 405."""

import itertools
from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Finding
from frontage.validation.cells import INSIDE, OPPOSITE, OUTSIDE, SAME, Pieces, Skin, compare
from frontage.validation.chambers import chambers
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.polygons import Triangles
from frontage.validation.shells import volume

Shell = tuple[Mesh, Triangles]


def check_solid(shells: Sequence[Shell]) -> list[Finding]:
    """Findings on the shells of a solid, outer one first, each valid in itself.

    Shells may touch in points and along lines, not share a piece of a face.
    """
    findings = _turned(shells)
    skins = [Skin(mesh.xyz, triangles.ids, mesh.noise) for mesh, triangles in shells]
    pairs = []
    for i, j in itertools.combinations(range(len(skins)), 2):
        one, other = compare(skins[i], skins[j]), compare(skins[j], skins[i])
        verdict = _with_outer(one, other) if i == 0 else _two_voids(one, other)
        if verdict is not None:
            code, text, at = verdict
            place = shells[0][0].place(at)
            pairs.append(Finding(code, text, f"shell={i}&shell={j}", "", place))
    if not pairs and len(skins) > 1:
        count = chambers(skins)
        if count > len(skins) + 1:
            text = f"the voids cut the inside into {count - len(skins)} separate pieces"
            middle = shells[0][0].place(skins[0].corners.mean((0, 1)))
            pairs.append(Finding(404, text, "", "", middle))
    return findings + pairs


def _turned(shells: Sequence[Shell]) -> list[Finding]:
    """405: the outer shell must look outwards, the others into their voids."""
    findings = []
    for k, (mesh, triangles) in enumerate(shells):
        signed = volume(mesh, triangles.ids)
        if (signed <= 0) if k == 0 else (signed >= 0):
            text = "all faces look inwards" if k == 0 else "the faces of the inner shell look out of its void"
            middle = mesh.place(mesh.xyz[triangles.ids].mean((0, 1)))
            findings.append(Finding(405, text, f"shell={k}", "", middle, qie=308 if k == 0 else None))
    return findings


def _with_outer(outer: Pieces, inner: Pieces) -> tuple[int, str, Float] | None:
    """The outer shell and one inner one."""
    both = (SAME, OPPOSITE)
    if inner.has(*both):
        if np.isin(inner.state, both).all() and np.isin(outer.state, both).all():
            return 402, "the inner shell is the same as the outer one", inner.place(*both)
        return 401, "the inner and the outer shell share a part of a face", inner.place(*both)
    if inner.has(INSIDE) and inner.has(OUTSIDE):
        return 401, "the inner shell passes through the outer one", inner.place(OUTSIDE)
    if outer.has(INSIDE):
        return (
            (401, "the shells pass through each other", outer.place(INSIDE))
            if inner.has(INSIDE)
            else (403, "the inner shell surrounds the outer one", inner.place(OUTSIDE))
        )
    return (
        (403, "the inner shell lies outside of the outer one", inner.place(OUTSIDE))
        if inner.has(OUTSIDE)
        else None
    )


def _two_voids(one: Pieces, other: Pieces) -> tuple[int, str, Float] | None:
    """Two inner shells."""
    both = (SAME, OPPOSITE)
    if one.has(*both):
        if np.isin(one.state, both).all() and np.isin(other.state, both).all():
            return 402, "two inner shells are the same", one.place(*both)
        return 401, "two inner shells share a part of a face", one.place(*both)
    if one.has(INSIDE) or other.has(INSIDE):
        inside = one if one.has(INSIDE) else other
        return 401, "the insides of two inner shells overlap", inside.place(INSIDE)
    return None
