"""Hosts: polygons of city models and blocks as closed solids, repaired only where that is unambiguous."""

import numpy as np
import pytest

from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.io.citymodels.read import read_city_model
from frontage.model import Failed, Solid, Surface
from frontage.solids.brep import GRID_PER_M, newell_normal, rings_of, volume6
from frontage.solids.cells.build import build_solid
from frontage.solids.coarse.extrude import facade_block, ground_block
from frontage.solids.coarse.host import Host, host_solid
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs, Relief
from frontage.validation import validate
from realdata import data_path
from solids.facades import WORLD, block, frame


def polygons(solid: Solid) -> list[Surface]:
    """Returns a solid's faces as a city model would hold them."""
    at = solid.vertices / GRID_PER_M
    rings = [[at[list(r)] for r in rings_of(f)] for f in solid.faces]
    return [Surface(r[0], f.semantics, "", tuple(r[1:])) for f, r in zip(solid.faces, rings, strict=True)]


def gabled() -> list[Surface]:
    return polygons(block(frame(0.6), np.array([[0, 0], [8, 0], [8, 6], [4, 9], [0, 6.0]])))


def host(surfaces: list[Surface], **options) -> Host:
    made = host_solid("B", surfaces, WORLD, **options)
    assert isinstance(made, Host), made
    assert not validate(made.solid)
    return made


def facades_of(solid: Solid, shift: float = 0.0) -> list[FacadeReliefs]:
    """Returns every large wall as a facade with as many windows as fit on it, and a door."""
    found = []
    for k, face in enumerate(solid.faces):
        ring = solid.vertices[list(face.ring)] / GRID_PER_M
        n = newell_normal(ring)
        if face.semantics != "WallSurface" or abs(n[2]) > 0.1:
            continue
        place = Rigid3("local", "facade", facade_axes(-n), ring.mean(0) + shift * n)
        outline = place.inverse.apply(ring)[:, [0, 2]]
        (x0, z0), (x1, z1) = outline.min(0), outline.max(0)
        spots = [(x, z) for x in np.arange(x0 + 0.5, x1 - 1, 2.3) for z in np.arange(z0 + 1, z1 - 2, 3.1)]
        own = [Relief(f"{k}/{x:.1f}/{z:.1f}", rectangle(x, z, x + 1, z + 1.4), 0.2) for x, z in spots]
        own.append(Relief(f"{k}/D", rectangle(x1 - 1.4, z0, x1 - 0.6, z0 + 0.9), 0.3, "Door"))
        found.append(FacadeReliefs(f"F{k}", place, outline, tuple(own)))
    return found


def test_good_polygons_are_not_changed():
    surfaces = gabled()
    made = host(surfaces)
    assert not made.notes
    for face, surface in zip(made.solid.faces, surfaces, strict=True):
        assert face.semantics == surface.semantics
        assert np.array_equal(made.solid.vertices[list(face.ring)], np.rint(surface.ring * GRID_PER_M))


def test_missing_ground_is_added():
    whole = gabled()
    made = host([s for s in whole if s.semantics != "GroundSurface"])
    assert made.notes == ("B: the ground surface was missing and has been added",)
    assert volume6(made.solid) == volume6(host(whole).solid)


def test_inside_out_host_is_reversed():
    made = host([Surface(s.ring[::-1], s.semantics) for s in gabled()])
    assert "reversed" in made.notes[0] and volume6(made.solid) > 0


def test_vertex_on_an_edge_of_a_neighbour_is_shared():
    surfaces = gabled()
    wall = surfaces[1]
    ring = np.insert(wall.ring, 1, wall.ring[:2].mean(0), axis=0)
    made = host([surfaces[0], Surface(ring, wall.semantics), *surfaces[2:]])
    assert "split at vertices" in made.notes[0]


def test_roof_a_little_off_its_walls_is_joined_to_them():
    surfaces = [
        Surface(s.ring + np.array([0.0, 0.0, 0.03]), s.semantics) if s.semantics == "RoofSurface" else s
        for s in gabled()
    ]
    made = host(surfaces)
    assert "0.05 m apart were joined" in made.notes[0]
    assert volume6(made.solid) == volume6(host(gabled()).solid)


def test_missing_wall_is_not_guessed():
    surfaces = [s for k, s in enumerate(gabled()) if k != 1]
    made = host_solid("B7", surfaces, WORLD)
    assert isinstance(made, Failed) and made.code == "S303"
    assert made.message.startswith("B7: the host is not closed: 5 edges")


def test_missing_roof_gets_a_lid_only_when_allowed():
    surfaces = [s for s in gabled() if s.semantics != "RoofSurface"]
    assert isinstance(host_solid("B", surfaces, WORLD), Failed)
    made = host(surfaces, lid=True)
    assert "lid of triangles" in made.notes[0]


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_polygons(count):
    made = host_solid("B", gabled()[:count], WORLD)
    assert isinstance(made, Failed) and made.code == "S302"


def test_uneven_wall_is_split_and_can_be_cut():
    surfaces = gabled()
    moved = [
        Surface(
            np.where(np.isclose(s.ring, surfaces[0].ring[2]).all(1)[:, None], s.ring + 0.04, s.ring),
            s.semantics,
        )
        for s in surfaces
    ]
    made = host(moved)
    assert "split into triangles" in made.notes[0]
    result = build_solid(made.solid, facades_of(made.solid))
    assert isinstance(result, Built) and not validate(result.solid)


def test_slightly_uneven_wall_stays_whole():
    """A corner 4 mm off the plane, as in many city models, does not change the host."""
    surfaces = gabled()
    n = newell_normal(surfaces[0].ring)
    corner = surfaces[0].ring[2]
    moved = [
        Surface(np.where(np.isclose(s.ring, corner).all(1)[:, None], s.ring + 0.004 * n, s.ring), s.semantics)
        for s in surfaces
    ]
    made = host(moved)
    assert not made.notes
    result = build_solid(made.solid, facades_of(made.solid))
    assert isinstance(result, Built) and not validate(result.solid)
    assert len([f for f in result.solid.faces if f.semantics == "Window"]) > 10


def test_block_of_a_bad_outline():
    bad = facade_block("B", frame(0.0), np.array([[0.0, 0], [1, 1], [1, 0], [0, 1]]), 5.0, WORLD)
    assert isinstance(bad, Failed) and bad.code == "S304"


@pytest.mark.parametrize("shift", [0.0, 0.31])
@pytest.mark.parametrize("reseat", [False, True])
def test_real_city_model(shift, reseat):
    """Every building of a city model gives a host, and openings can be cut into all its walls."""
    model = read_city_model(data_path("ingolstadt_scene/input/lod2/lod2.gml"))
    cut = 0
    for building in model.buildings:
        surfaces = building.level("2")[0].surfaces
        made = host_solid(building.id, surfaces, model.world, lid=True)
        if isinstance(made, Failed):
            assert made.code == "S303"
            made = ground_block(building.id, surfaces, model.world)
        assert isinstance(made, Host) and made.notes
        assert not validate(made.solid)
        result = build_solid(made.solid, facades_of(made.solid, shift), BuildOptions(reseat=reseat))
        assert isinstance(result, Built)
        assert not validate(result.solid), building.id
        assert "S399" not in {f.code for f in result.failed}
        if not reseat:
            assert result.host is made.solid
            assert all(d == pytest.approx(shift, abs=0.02) for d in result.offsets.values())
        cut += len([f for f in result.solid.faces if f.opening])
    assert cut > 100
