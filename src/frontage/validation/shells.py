"""Level 3: faces must form one closed, oriented, simple surface. Codes 301 to 307."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Float, Int
from frontage.model import Finding
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.polygons import Triangles
from frontage.validation.selfcross import check_crossings
from frontage.validation.tolerances import Tolerances
from frontage.validation.topology import Topology


def check_shell(
    mesh: Mesh, triangles: Triangles, tolerances: Tolerances, closed: bool = True, inner: bool = False
) -> list[Finding]:
    """Findings on a shell whose faces are all valid; not `closed`: a CompositeSurface, which may have a rim.

    `inner`: the shell bounds a void, its faces look into it.
    """
    number = len(mesh.faces) - 1
    if closed and number < 4:
        return [Finding(301, f"{number} faces; a solid needs at least 4", "", "", _middle(mesh))]
    topology = Topology.of(triangles, number)
    gaps = _gaps(mesh, topology) if closed else []
    crowded = _crowded(mesh, topology, closed)
    findings = gaps + crowded + _apart(mesh, topology)
    findings += _turned(mesh, topology, closed and not gaps, inner)
    if not gaps and not crowded:
        findings += check_crossings(mesh, triangles, tolerances)
    return sorted(findings, key=lambda f: f.code)


def volume(mesh: Mesh, triangles: Int) -> float:
    """Signed volume (m3) inside closed triangles (t, 3); positive when they look outwards."""
    return float(signed_volumes(mesh.xyz, triangles).sum())


def signed_volumes(xyz: Float, triangles: Int) -> Float:
    """Volumes (t,) of the tetrahedra from the first triangle's corner to each triangle."""
    if not len(triangles):
        return np.zeros(0)
    a, b, c = (xyz[triangles[:, k]] - xyz[triangles[0, 0]] for k in range(3))
    return np.asarray(np.einsum("ti,ti->t", a, np.cross(b, c)) / 6)


def _middle(mesh: Mesh) -> tuple[float, float, float] | None:
    return mesh.place(mesh.xyz[mesh.corners].mean(0)) if len(mesh.corners) else None


def _gaps(mesh: Mesh, topology: Topology) -> list[Finding]:
    """302: rims of the main part, and 303 where a rim is only a vertex that a neighbour lacks."""
    face = topology.triangles.edge_face
    free = (topology.uses[topology.edge] == 1) & (topology.component[face] == topology.main)
    ends = topology.triangles.edges[free]
    if not len(ends):
        return []
    findings = []
    rim = _rims(ends)
    for label in np.unique(rim):
        own = ends[rim == label]
        at = mesh.place(mesh.xyz[own].mean((0, 1)))
        names = _names(mesh, face[free][rim == label])
        text = f"a rim of {len(own)} edges with a face on one side only"
        findings += [Finding(302, text, names, "", at), *_lacking(mesh, own)]
    return findings


def _rims(ends: Int) -> Int:
    """Which connected rim every free edge (n, 2) belongs to."""
    vertices, flat = np.unique(ends, return_inverse=True)
    a, b = flat.reshape(-1, 2).T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(vertices), len(vertices)))
    return np.asarray(connected_components(graph, directed=False)[1][a])


def _lacking(mesh: Mesh, ends: Int) -> list[Finding]:
    """303 for a rim that is no hole, because it runs to and fro on one line: a vertex only one face has."""
    vertices = np.unique(ends)
    xyz = mesh.xyz[vertices] - mesh.xyz[vertices].mean(0)
    along = np.linalg.svd(xyz)[2][0]
    if np.linalg.norm(xyz - np.outer(xyz @ along, along), axis=1).max() > mesh.noise:
        return []
    inner = vertices[np.argsort(xyz @ along)[1:-1]]
    text = "a vertex on an edge that only one of the two faces has there"
    return [
        Finding(303, text, f"vertex={int(k)}", "", mesh.place(mesh.xyz[k]), qie=304) for k in np.sort(inner)
    ]


def _names(mesh: Mesh, faces: Int) -> str:
    """Up to three faces by name."""
    unique = np.unique(faces)
    return "&".join(mesh.face(int(f)) for f in unique[:3]) + ("&..." if len(unique) > 3 else "")


def _crowded(mesh: Mesh, topology: Topology, closed: bool) -> list[Finding]:
    """303: edges with more than two faces, vertices with more than one fan."""
    findings = []
    for e in np.nonzero(topology.uses > 2)[0]:
        text = f"an edge with {topology.uses[e]} faces"
        at = mesh.place(mesh.xyz[topology.ends[e]].mean(0))
        names = _names(mesh, topology.triangles.edge_face[topology.edge == e])
        findings.append(Finding(303, text, names, "", at, qie=304))
    for v in topology.crowded_vertices(open_fans=not closed):
        text = "a vertex whose faces form more than one fan"
        names = _names(mesh, mesh.face_of_corner[mesh.corners == v])
        findings.append(Finding(303, text, names, "", mesh.place(mesh.xyz[v])))
    return findings


def _apart(mesh: Mesh, topology: Topology) -> list[Finding]:
    """305: faces that not even a vertex joins to the main part."""
    main = topology.group[np.argmax(topology.component == topology.main)]
    findings = []
    for label in np.unique(topology.group[topology.group != main]):
        faces = np.nonzero(topology.group == label)[0]
        at = mesh.place(mesh.xyz[mesh.corners[np.isin(mesh.face_of_corner, faces)]].mean(0))
        text = f"{len(faces)} faces are not connected to the others"
        findings.append(Finding(305, text.replace("1 faces are", "1 face is"), _names(mesh, faces), "", at))
    return findings


def _turned(mesh: Mesh, topology: Topology, closed: bool, inner: bool) -> list[Finding]:
    """307: faces turned the other way than the rest; in a closed shell, those that look inwards."""
    if not topology.same_way.any():
        return []
    colour, torn = topology.colours()
    wrong = []
    for label in np.unique(topology.component):
        own = topology.component == label
        if len(np.unique(colour[own])) > 1:
            wrong.append(
                np.nonzero(own & (colour == _wrong_colour(mesh, topology, own, colour, closed, inner)))[0]
            )
    if torn.any():
        wrong.append(topology.triangles.edge_face[topology.pairs[torn]][:, 0])
    text = "the face is turned the other way than its neighbours"
    return [
        Finding(307, text, mesh.face(int(f)), "", _face_middle(mesh, int(f)))
        for f in np.unique(np.concatenate(wrong))
    ]


def _wrong_colour(mesh: Mesh, topology: Topology, own: Int, colour: Int, closed: bool, inner: bool) -> int:
    """The colour whose faces look the wrong way, by volume; of an open part the one with fewer faces."""
    if closed:
        chosen = own[topology.triangles.face]
        parts = signed_volumes(mesh.xyz, topology.triangles.ids[chosen])
        sign = 1 - 2 * colour[topology.triangles.face[chosen]]
        return 1 if (parts @ sign > 0) != inner else 0
    return int(np.argmin(np.bincount(colour[own], minlength=2)))


def _face_middle(mesh: Mesh, face: int) -> tuple[float, float, float]:
    own = slice(mesh.rings[mesh.faces[face]], mesh.rings[mesh.faces[face] + 1])
    return mesh.place(mesh.xyz[mesh.corners[own]].mean(0))
