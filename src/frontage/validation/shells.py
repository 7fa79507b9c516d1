"""Level 3: faces must form one closed, oriented, simple surface. Codes 301 to 307."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Finding
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.triangulate import Triangles
from frontage.validation.self_intersection import check_self_intersection
from frontage.validation.tolerances import Tolerances
from frontage.validation.topology import Topology

_FEWEST_FACES = 4  # of a closed shell: a tetrahedron
_MOST_NAMED = 3  # faces that a finding names


def check_shell(
    mesh: Mesh, triangles: Triangles, tolerances: Tolerances, closed: bool = True, inner: bool = False
) -> list[Finding]:
    """Checks a shell whose faces are all valid.

    `closed` is false for a CompositeSurface, which may have a border. `inner` is true for a shell that bounds
    a void; its faces look into the void.
    """
    number = len(mesh.faces) - 1
    if closed and number < _FEWEST_FACES:
        return [Finding(301, f"{number} faces; a solid needs at least 4", "", "", _middle(mesh))]
    topology = Topology.of(triangles, number)
    holes = _open_borders(mesh, topology) if closed else []
    non_manifold = _non_manifold(mesh, topology, closed)
    findings = holes + non_manifold + _unconnected_faces(mesh, topology)
    findings += _reversed_faces(mesh, topology, closed and not holes, inner)
    if not holes and not non_manifold:
        findings += check_self_intersection(mesh, triangles, tolerances)
    return sorted(findings, key=lambda f: f.code)


def volume(mesh: Mesh, triangles: Int) -> float:
    """Returns the signed volume (m3) inside closed triangles (t, 3); positive if they look outwards."""
    return float(_signed_volumes(mesh.xyz, triangles).sum())


def _signed_volumes(xyz: Float, triangles: Int) -> Float:
    """Returns the volumes (t,) of the tetrahedra from the first triangle's corner to each triangle."""
    if not len(triangles):
        return np.zeros(0)
    a, b, c = (xyz[triangles[:, k]] - xyz[triangles[0, 0]] for k in range(3))
    return np.asarray(np.einsum("ti,ti->t", a, np.cross(b, c)) / 6)


def _middle(mesh: Mesh) -> tuple[float, float, float] | None:
    return mesh.location(mesh.xyz[mesh.corners].mean(0)) if len(mesh.corners) else None


def _open_borders(mesh: Mesh, topology: Topology) -> list[Finding]:
    """302: the largest component has free edges; also 303 if only a vertex is missing in a neighbour."""
    face = topology.triangles.edge_face
    free = (topology.uses[topology.edge] == 1) & (topology.edge_component[face] == topology.largest_component)
    ends = topology.triangles.edges[free]
    if not len(ends):
        return []
    findings = []
    border = _connected_borders(ends)
    for label in np.unique(border):
        own = ends[border == label]
        at = mesh.location(mesh.xyz[own].mean((0, 1)))
        names = _face_names(mesh, face[free][border == label])
        text = f"{len(own)} connected edges have a face on one side only"
        findings += [Finding(302, text, names, "", at), *_missing_vertices(mesh, own)]
    return findings


def _connected_borders(ends: Int) -> Int:
    """Returns the connected border (n,) that each free edge (n, 2) belongs to."""
    vertices, flat = np.unique(ends, return_inverse=True)
    a, b = flat.reshape(-1, 2).T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(vertices), len(vertices)))
    return np.asarray(connected_components(graph, directed=False)[1][a])


def _missing_vertices(mesh: Mesh, ends: Int) -> list[Finding]:
    """303: a border that runs back and forth on one line is no hole, but has vertices that one face lacks."""
    vertices = np.unique(ends)
    xyz = mesh.xyz[vertices] - mesh.xyz[vertices].mean(0)
    along = np.linalg.svd(xyz)[2][0]
    if np.linalg.norm(xyz - np.outer(xyz @ along, along), axis=1).max() > mesh.noise:
        return []
    inner = vertices[np.argsort(xyz @ along)[1:-1]]
    text = "a vertex on a common edge belongs to only one of the two faces"
    return [
        Finding(303, text, f"vertex={int(k)}", "", mesh.location(mesh.xyz[k]), qie=304)
        for k in np.sort(inner)
    ]


def _face_names(mesh: Mesh, faces: Int) -> str:
    """Returns up to three faces by name."""
    unique = np.unique(faces)
    more = "&..." if len(unique) > _MOST_NAMED else ""
    return "&".join(mesh.face_name(int(f)) for f in unique[:_MOST_NAMED]) + more


def _non_manifold(mesh: Mesh, topology: Topology, closed: bool) -> list[Finding]:
    """303: an edge has more than two faces, or the faces of a vertex form more than one fan."""
    findings = []
    for e in np.nonzero(topology.uses > 2)[0]:
        text = f"an edge has {topology.uses[e]} faces"
        at = mesh.location(mesh.xyz[topology.ends[e]].mean(0))
        names = _face_names(mesh, topology.triangles.edge_face[topology.edge == e])
        findings.append(Finding(303, text, names, "", at, qie=304))
    for v in topology.non_manifold_vertices(open_fans=not closed):
        text = "the faces of a vertex form more than one fan"
        names = _face_names(mesh, mesh.face_of_corner[mesh.corners == v])
        findings.append(Finding(303, text, names, "", mesh.location(mesh.xyz[v])))
    return findings


def _unconnected_faces(mesh: Mesh, topology: Topology) -> list[Finding]:
    """305: faces share not even a vertex with the largest component."""
    in_largest = np.argmax(topology.edge_component == topology.largest_component)
    main = topology.vertex_component[in_largest]
    findings = []
    for label in np.unique(topology.vertex_component[topology.vertex_component != main]):
        faces = np.nonzero(topology.vertex_component == label)[0]
        at = mesh.location(mesh.xyz[mesh.corners[np.isin(mesh.face_of_corner, faces)]].mean(0))
        count = "1 face is" if len(faces) == 1 else f"{len(faces)} faces are"
        text = f"{count} not connected to the others"
        findings.append(Finding(305, text, _face_names(mesh, faces), "", at))
    return findings


def _reversed_faces(mesh: Mesh, topology: Topology, closed: bool, inner: bool) -> list[Finding]:
    """307: a face is oriented against its neighbours; in a closed shell, those that look the wrong way."""
    if not topology.same_direction.any():
        return []
    colour, contradicting = topology.orientations()
    wrong = []
    for label in np.unique(topology.edge_component):
        own = topology.edge_component == label
        if len(np.unique(colour[own])) > 1:
            if closed:
                minority = _inward_colour(mesh, topology, own, colour, inner)
            else:
                minority = int(np.argmin(np.bincount(colour[own], minlength=2)))
            wrong.append(np.nonzero(own & (colour == minority))[0])
    if contradicting.any():
        wrong.append(topology.triangles.edge_face[topology.pairs[contradicting]][:, 0])
    text = "the face is oriented against its neighbours"
    return [
        Finding(307, text, mesh.face_name(int(f)), "", _face_middle(mesh, int(f)))
        for f in np.unique(np.concatenate(wrong))
    ]


def _inward_colour(mesh: Mesh, topology: Topology, own: Bool, colour: Int, inner: bool) -> int:
    """Returns the colour of the faces (f,) that look the wrong way, by the volume of the component `own`."""
    chosen = own[topology.triangles.face]
    parts = _signed_volumes(mesh.xyz, topology.triangles.ids[chosen])
    sign = 1 - 2 * colour[topology.triangles.face[chosen]]
    return 1 if (parts @ sign > 0) != inner else 0


def _face_middle(mesh: Mesh, face: int) -> tuple[float, float, float]:
    own = slice(mesh.rings[mesh.faces[face]], mesh.rings[mesh.faces[face] + 1])
    return mesh.location(mesh.xyz[mesh.corners[own]].mean(0))
