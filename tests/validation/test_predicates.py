"""Signs are exact where floating point is not; boxes and triangles agree with brute force."""

from fractions import Fraction

import numpy as np
import pytest

from frontage.geometry.arrays import Float, Int
from frontage.validation.closed_surface import ClosedSurface
from frontage.validation.complement import complement_components
from frontage.validation.geometry.boxes import box_pairs
from frontage.validation.geometry.distances import to_closest_triangle, winding_numbers
from frontage.validation.geometry.mesh import weld
from frontage.validation.geometry.predicates import orient2d, orient3d
from frontage.validation.geometry.triangle_pairs import triangles_meet
from validation.models import Model, box, pyramid


def exact_volume(points: Int) -> int:
    u, v, w = ([Fraction(int(a)) - int(b) for a, b in zip(p, points[3], strict=True)] for p in points[:3])
    det = sum(u[k] * (v[(k + 1) % 3] * w[(k + 2) % 3] - v[(k + 2) % 3] * w[(k + 1) % 3]) for k in range(3))
    return -((det > 0) - (det < 0))


def test_the_sign_of_a_volume_is_exact() -> None:
    """Doubles cannot tell whether points with large integer coordinates lie on a plane or one unit off it."""
    r = np.random.default_rng(1)
    rows = []
    for _ in range(300):
        a, u, v = r.integers(-(2**45), 2**45, (3, 3))
        s, t = r.integers(-3, 4, 2)
        off = r.integers(-1, 2, 3) * r.integers(0, 2)
        rows.append([a, a + u // 8, a + v // 8, a + s * (u // 8) + t * (v // 8) + off])
    grid = np.array(rows).reshape(-1, 3)
    ids = np.arange(len(grid)).reshape(-1, 4)
    got = orient3d(grid, *ids.T)
    expected = [exact_volume(grid[i]) for i in ids]
    assert got.tolist() == expected
    assert 0 < np.count_nonzero(got == 0) < len(got)


def test_the_sign_of_an_area_is_exact() -> None:
    r = np.random.default_rng(2)
    a, u = r.integers(-(2**40), 2**40, (2, 200, 2))
    k = r.integers(-5, 6, (200, 1))
    off = r.integers(-1, 2, (200, 2)) * r.integers(0, 2, (200, 1))
    b, c = a + u, a + k * u + off
    exact = [int(x[0]) * int(y[1]) - int(x[1]) * int(y[0]) for x, y in zip(a - c, b - c, strict=True)]
    assert orient2d(a, b, c).tolist() == [(e > 0) - (e < 0) for e in exact]


def triangle_soup(n: int, seed: int) -> tuple[Int, Int]:
    r = np.random.default_rng(seed)
    return r.integers(0, 6, (3 * n, 3)), np.arange(3 * n).reshape(-1, 3)


def rational_meet(one: Int, other: Int) -> bool:
    """Decides with rational numbers whether an edge of one closed triangle pierces or touches the other."""

    def side(p: Int, t: Int) -> int:
        return exact_volume(np.array([*t, p]))

    def in_plane(p: tuple[Fraction, ...], t: Int) -> bool:
        n = np.cross(t[1] - t[0], t[2] - t[0])
        k = int(np.argmax(np.abs(n)))
        i, j = [m for m in range(3) if m != k]
        turns = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            du, dv = int(t[b][i] - t[a][i]), int(t[b][j] - t[a][j])
            turns.append(du * (p[j] - int(t[a][j])) - dv * (p[i] - int(t[a][i])))
        return all(x >= 0 for x in turns) or all(x <= 0 for x in turns)

    for s, t in ((one, other), (other, one)):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            p, q = s[a], s[b]
            n = [int(x) for x in np.cross(t[1] - t[0], t[2] - t[0])]
            hp = sum(x * int(y) for x, y in zip(n, p - t[0], strict=True))
            hq = sum(x * int(y) for x, y in zip(n, q - t[0], strict=True))
            if hp * hq > 0 or hp == hq:
                continue
            w = Fraction(hp, hp - hq)
            spot = tuple(int(x) + w * (int(y) - int(x)) for x, y in zip(p, q, strict=True))
            if in_plane(spot, t):
                return True
    return False


def test_triangles_meet_exactly_when_rationals_say_so() -> None:
    """With small integer coordinates, touches at corners and edges are common. Coplanar ones are left out."""
    grid, ids = triangle_soup(400, 3)
    flat = np.array([not np.cross(grid[t[1]] - grid[t[0]], grid[t[2]] - grid[t[0]]).any() for t in ids])
    ids = ids[~flat]
    first, second = ids[: len(ids) // 2], ids[len(ids) // 2 : len(ids) // 2 * 2]
    normal = np.cross(grid[first[:, 1]] - grid[first[:, 0]], grid[first[:, 2]] - grid[first[:, 0]])
    beside = np.einsum("tki,ti->tk", grid[second] - grid[first[:, 0]][:, None], normal)
    skew = (beside != 0).any(1)
    got = triangles_meet(grid, first[skew], second[skew])
    expected = [rational_meet(grid[a], grid[b]) for a, b in zip(first[skew], second[skew], strict=True)]
    assert got.tolist() == expected
    assert 10 < np.count_nonzero(got) < len(got) - 10


@pytest.mark.parametrize(
    ("second", "expected"),
    [
        ([(1, 1, 0), (3, 1, 0), (1, 3, 0)], True),
        ([(5, 5, 0), (6, 5, 0), (5, 6, 0)], False),
        ([(4, 0, 0), (6, 0, 0), (6, 2, 0)], True),
        ([(3, 3, 0), (6, 3, 0), (3, 6, 0)], False),
        ([(-1, -1, 0), (9, -1, 0), (-1, 9, 0)], True),
        ([(1, 1, 0), (2, 1, 0), (1, 2, 0)], True),
        ([(-1, 0, 0), (5, 0, 0), (2, -3, 0)], True),
    ],
)
def test_triangles_in_one_plane(second: list[tuple[int, int, int]], expected: bool) -> None:
    grid = np.array([(0, 0, 0), (4, 0, 0), (0, 4, 0), *second])
    one, other = np.array([[0, 1, 2]]), np.array([[3, 4, 5]])
    assert triangles_meet(grid, one, other).tolist() == [expected]
    assert triangles_meet(grid, other, one[:, [2, 0, 1]]).tolist() == [expected]


def test_common_vertices_and_edges_do_not_count() -> None:
    grid = np.array([(0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0), (2, 2, 3), (1, 1, 0), (3, 1, 0), (4, 0, 4)])

    def meet(a: list[int], b: list[int]) -> bool:
        return bool(triangles_meet(grid, np.array([a]), np.array([b]))[0])

    assert not meet([0, 1, 2], [1, 3, 2])  # an edge, side by side
    assert not meet([0, 1, 2], [1, 4, 2])  # an edge, folded up
    assert meet([0, 1, 2], [1, 2, 5])  # an edge, folded onto each other
    assert not meet([0, 1, 2], [1, 3, 7])  # a corner
    assert meet([0, 1, 2], [1, 5, 4])  # a corner, and the edge opposite touches
    assert meet([0, 1, 2], [2, 1, 0])


def test_box_pairs_are_all_pairs_of_close_boxes() -> None:
    r = np.random.default_rng(4)
    xyz = r.uniform(0, 4, (120, 3))
    ids = np.arange(120).reshape(-1, 3)
    pairs = {tuple(p) for p in box_pairs(xyz, ids, None, 1e-6).tolist()}
    grid = np.rint(xyz * 2**30).astype(np.int64)
    every = np.array([(i, j) for i in range(40) for j in range(i + 1, 40)])
    hit = triangles_meet(grid, ids[every[:, 0]], ids[every[:, 1]])
    assert {tuple(p) for p in every[hit].tolist()} <= pairs
    assert 0 < np.count_nonzero(hit) < len(pairs) < len(every)


def corners(model: Model) -> Float:
    """Returns the triangles of a model whose faces are convex."""
    return np.array(
        [model.xyz[[f[0][0], f[0][k], f[0][k + 1]]] for f in model.faces for k in range(1, len(f[0]) - 1)]
    )


def test_winding_and_distance() -> None:
    points = np.array([(0.5, 0.5, 0.5), (0.5, 0.5, 1.25), (2.0, 2.0, 0.5), (0.9, 0.1, 0.2)])
    cube = corners(box())
    assert winding_numbers(points, cube) == pytest.approx([1, 0, 0, 1], abs=1e-12)
    assert winding_numbers(points, corners(box().turned())) == pytest.approx([-1, 0, 0, -1], abs=1e-12)
    assert to_closest_triangle(points, cube)[0] == pytest.approx([0.5, 0.25, np.sqrt(2), 0.1])


def surface(model: Model) -> ClosedSurface:
    mesh = weld([model.surfaces()], 0.001)[0]
    ids = np.array(
        [(f[0][0], f[0][k], f[0][k + 1]) for f in model.faces for k in range(1, len(f[0]) - 1)], np.int64
    )
    order = {tuple(np.round(p, 6)): k for k, p in enumerate(mesh.xyz + mesh.origin)}
    number = np.array([order[tuple(np.round(p, 6))] for p in model.xyz])
    return ClosedSurface(mesh.xyz + mesh.origin, number[ids], mesh.noise)


def test_components_of_the_complement() -> None:
    tip = pyramid([(0.2, 0.2, 0.2), (0.8, 0.2, 0.2), (0.8, 0.8, 0.2), (0.2, 0.8, 0.2)], (0.5, 0.5, 1.0))
    blocker = pyramid([(0, 0.5, 0.2), (0.5, 0, 0.2), (1, 0.5, 0.2), (0.5, 1, 0.2)], (0.5, 0.5, 0.8))
    assert complement_components([surface(box())]) == 2
    assert complement_components([surface(box()), surface(tip)]) == 3
    assert complement_components([surface(box()), surface(blocker)]) == 3


def test_chains_of_close_vertices_are_cut_not_collapsed() -> None:
    """A round arch whose chords are shorter than the tolerance keeps its shape."""
    line = np.column_stack([np.arange(21) * 0.0009, np.zeros(21), np.zeros(21)])
    model = Model(np.vstack([line, [(0.01, 1, 0)]]), ((tuple(range(22)),),))
    mesh = weld([model.surfaces()], 0.001)[0]
    x = np.unique(mesh.xyz[:, 0])
    assert 10 <= len(mesh.xyz) <= 13
    assert np.diff(x).max() < 0.002 and x[-1] - x[0] > 0.016
