"""Buildings from their facades: reliefs, installations, and where the coarse solid comes from."""

from dataclasses import replace

import numpy as np
import pytest

from facade_fakes import WORLD, facade
from frontage.geometry.ring import rectangle
from frontage.model import (
    Building,
    Elements,
    Estimate,
    Facade,
    Failed,
    Finding,
    Opening,
    Protrusion,
    Provenance,
    Surface,
)
from frontage.model.citymodel import CityBuilding, Shell
from frontage.solids import (
    Assembled,
    BuildOptions,
    ModelMatch,
    assemble,
    facades_of_matches,
    match_model,
    sound,
)
from frontage.solids.brep import GRID_PER_M, volume6
from frontage.solids.coarse.eaves import clean_outline
from frontage.solids.elements import facade_parts
from frontage.solids.installations.shapes import PARAPET_M, SLAB_M
from frontage.validation import validate
from opening_fakes import opening, round_door
from solids.test_build_host import polygons

GROUND = 15.125 - 3.2  # m local, 20 cm under the outline's foot


def wall(wide: float = 10.0, turn: float = 0.7, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Facade:
    """Returns an upright facade 6 m high; `at` moves its origin (m) along its own axes."""
    f = facade(azimuth=turn, lean=0.0)
    pose = replace(f.frame, t=f.frame.apply(np.array([at]))[0])
    outline = rectangle(-wide / 2, -3, wide / 2, 3)
    return replace(f, local_from_facade=Estimate(pose, np.eye(6) * 1e-8, 500.0), outline=outline)


def protrusion(kind: str, box: tuple[float, float, float, float], front: float) -> Protrusion:
    depth = Estimate(front, np.array([[1e-4]]), 9.0)
    return Protrusion(f"B01/F1/{kind}", kind, rectangle(*box), 0.01, depth, Provenance.MEASURED, 0.9)


def window(name: str, box: tuple[float, float, float, float], depth: float | None = 0.12) -> Opening:
    deep = None if depth is None else Estimate(depth, np.array([[1e-4]]), 9.0)
    one = opening(name, box)
    return replace(one, depth=deep, glazing=None if depth is None else one.glazing)


def house(at: Facade, elements: Elements, **options) -> Assembled:
    made = assemble(
        Building("B01", np.arange(3), GROUND), [(at, elements)], (), WORLD, BuildOptions(**options)
    )
    assert isinstance(made, Assembled), made
    assert not any(validate(b.solid) for b in made.built)
    assert not any(validate(i.solid) for i in made.installations)
    return made


def faces(made: Assembled, name: str) -> list:
    return [f for b in made.built for f in b.solid.faces if f.opening == name]


def test_depth_reveal_and_flush():
    deep, flat = window("W1", (-4, -1, -3, 1)), window("W2", (-2, -1, -1, 1), None)
    made = house(wall(), Elements("B01/F1", (deep, flat, round_door())))
    coarse = volume6(made.built[0].host) / 6e12
    assert coarse == pytest.approx(10 * 6.2 * 8, abs=0.05)
    assert coarse - volume6(made.built[0].solid) / 6e12 == pytest.approx(2 * 0.12, abs=1e-3)
    assert [faces(made, n)[0].semantics for n in ("W1", "W2", "B01/F1/D0-1")] == ["Window", "Window", "Door"]
    assert made.coarse.source == "cloud" and made.fine == (True,) and not made.failed


def test_openings_on_an_oriel_stand_in_its_front():
    bay = protrusion("oriel", (-2, -1, 2, 2), -0.8)
    pane = window("W1", (-1, 0, 1, 1.5), 0.2)
    made = house(wall(), Elements("B01/F1", (pane,), (bay,)))
    gain = volume6(made.built[0].solid) - volume6(made.built[0].host)
    assert gain / 6e12 == pytest.approx(4 * 3 * 0.8 - 2 * 1.5 * 0.2, abs=2e-3)
    ring = made.built[0].solid.vertices[list(faces(made, "W1")[0].ring)] / GRID_PER_M
    assert wall().frame.inverse.apply(ring)[:, 1] == pytest.approx(-0.6, abs=1e-3)
    assert set(made.built[0].offsets) == {"W1", "B01/F1/oriel"}


def test_the_depth_of_a_volume_on_a_volume_counts_from_it():
    bay, step = protrusion("risalit", (-3, -3, 3, 3), -0.5), protrusion("oriel", (-1, 0, 1, 2), -1.1)
    parts = facade_parts(wall(), Elements("B01/F1", (), (step, bay)), 0.005)
    (outer,) = parts.reliefs.reliefs
    assert (outer.id, outer.depth) == ("B01/F1/risalit", -0.5)
    assert [(r.id, round(r.depth or 0, 9)) for r in outer.inside] == [("B01/F1/oriel", -0.6)]


def test_a_door_interrupts_the_plinth():
    plinth = protrusion("plinth", (-5, -3, 5, -2.4), -0.1)
    door = replace(window("D", (-1, -3, 0, -0.8), 0.2), kind="door")
    cellar = window("C", (2, -2.9, 3, -2.5), 0.15)
    made = house(wall(), Elements("B01/F1", (door, cellar), (plinth,)))
    assert not made.failed
    (pane,) = faces(made, "D")
    ring = made.built[0].solid.vertices[list(pane.ring)] / GRID_PER_M
    assert np.ptp(wall().frame.inverse.apply(ring)[:, 2]) == pytest.approx(2.2, abs=0.01)
    assert len(faces(made, "B01/F1/plinth")) == 1 and len(faces(made, "B01/F1/plinth-2")) == 1
    assert len(faces(made, "C")) == 1


def test_an_opening_names_the_volume_that_it_stands_on():
    bay = protrusion("oriel", (-2, -1, 2, 2), -0.8)
    pane = replace(window("W1", (1.5, 0, 2.9, 1.5), 0.2), on="B01/F1/oriel")
    parts = facade_parts(wall(), Elements("B01/F1", (pane,), (bay,)), 0.005)
    assert [r.id for r in parts.reliefs.reliefs[0].inside] == ["W1"]
    parts = facade_parts(wall(), Elements("B01/F1", (replace(pane, on=""),), (bay,)), 0.005)
    assert [r.id for r in parts.reliefs.reliefs] == ["B01/F1/oriel", "W1"]


def test_anything_set_back_shapes_the_wall_whatever_its_kind():
    made = house(wall(), Elements("B01/F1", (), (protrusion("protrusion", (-1, -1, 1, 1), 0.4),)))
    assert not made.installations and faces(made, "B01/F1/protrusion")[0].semantics == "WallSurface"


def test_balcony_is_a_tray_against_the_wall():
    at = wall()
    made = house(at, Elements("B01/F1", (), (protrusion("balcony", (-1, 0, 2, 1.2), -1.0),)))
    (balcony,) = made.installations
    volume = 3 * SLAB_M + (1.2 - SLAB_M) * PARAPET_M * (2 * 1.0 + 3 - 2 * PARAPET_M)
    assert volume6(balcony.solid) / 6e12 == pytest.approx(volume, abs=1e-3)
    y = at.frame.inverse.apply(balcony.solid.vertices / GRID_PER_M)[:, 1]
    assert (y.min(), y.max()) == (pytest.approx(-1.0, abs=1e-3), pytest.approx(0.0, abs=1e-3))
    assert "assumed" not in balcony.kind and "slab" in balcony.assumed
    assert volume6(made.built[0].solid) == volume6(made.built[0].host)


@pytest.mark.parametrize("kind", ["awning", "cornice", "protrusion"])
def test_other_installations(kind):
    made = house(wall(), Elements("B01/F1", (), (protrusion(kind, (-4, 1, 4, 1.8), -0.6),)))
    box = 8 * 0.8 * 0.6
    volume = volume6(made.installations[0].solid) / 6e12
    assert volume == pytest.approx(8 * 0.05 * 0.6 if kind == "awning" else box, abs=2e-3)


def test_steps_of_an_outline_below_the_snap_tolerance_are_removed():
    string = protrusion("band", (-4, 1, 4, 1.2), -0.05)
    step = np.array([[-4, 1], [0.5, 1], [0.5, 1.0003], [4, 1.0003], [4, 1.2], [-4, 1.2]], float)
    made = house(wall(), Elements("B01/F1", (), (replace(string, ring=step),)))
    (installed,) = made.installations
    assert not made.failed and not validate(installed.solid)
    gap = 2e-4  # m between the wall and what hangs on it
    assert volume6(installed.solid) / 6e12 == pytest.approx(8 * 0.2 * (0.05 - gap), abs=2e-4)


def test_an_awning_on_an_oriel_begins_at_its_front():
    elements = Elements(
        "B01/F1", (), (protrusion("oriel", (-2, -1, 2, 2), -0.8), protrusion("awning", (-1, 0, 1, 1), -1.5))
    )
    made = house(wall(), elements)
    y = wall().frame.inverse.apply(made.installations[0].solid.vertices / GRID_PER_M)[:, 1]
    assert y.max() == pytest.approx(-0.8, abs=1e-3)


def test_an_outline_that_crosses_itself_keeps_its_largest_part():
    ring = np.array([[-1, -1], [1, -1], [1, 1], [0.9, 1.1], [1, 1.2], [0.95, 0.9], [-1, 1.0]])
    odd = replace(window("W1", (-1, -1, 1, 1)), ring=ring, ring_covariance=np.eye(14) * 1e-6)
    made = house(wall(), Elements("B01/F1", (odd,)))
    assert not made.failed and len(faces(made, "W1")) == 1


def test_without_depth_openings_are_flush_and_nothing_is_installed():
    elements = Elements(
        "B01/F1", (window("W1", (-4, -1, -3, 1)),), (protrusion("balcony", (0, 0, 2, 1.2), -1),)
    )
    made = house(wall(), elements, depth=False)
    assert volume6(made.built[0].solid) == volume6(made.built[0].host)
    assert faces(made, "W1") and not made.installations


def test_a_protrusion_that_does_not_stand_out_is_left_out_with_a_note():
    made = house(wall(), Elements("B01/F1", (), (protrusion("railing", (-1, 0, 1, 1), -0.01),)))
    assert not made.failed and not made.installations
    assert "B01/F1/railing: left out because it stands out by less than 0.02 m" in made.notes


def test_a_refused_opening_names_the_one_that_takes_its_place():
    first, second = window("W1", (-2, -1, 0, 1)), window("W2", (-1.8, -0.8, 0.4, 0.8))
    made = house(wall(), Elements("B01/F1", (first, second)))
    (refused,) = made.failed
    assert refused.code == "S311" and refused.message.endswith("lies on wall that W1 leaves free")


def test_only_what_makes_a_solid_invalid_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault of one opening costs that opening, not those of the whole building."""
    names = [f"B01/F1/W1-{k}" for k in range(1, 8)]
    windows = tuple(window(name, (k - 4.0, 0.0, k - 3.4, 1.0)) for k, name in enumerate(names))
    wrong = Finding(204, "for this test", "", "B01")
    bad = {names[2], names[5]}
    monkeypatch.setattr(
        sound, "validate", lambda solid: [wrong] if bad & {f.opening for f in solid.faces} else []
    )
    made = house(wall(), Elements("B01/F1", windows))
    assert {f.opening for f in made.built[0].solid.faces} - {None} == set(names) - bad
    (told,) = made.failed
    assert told.code == "S320" and all((name in told.message) == (name in bad) for name in names)


def test_a_cornice_above_the_eaves_is_attached_to_the_wall_below():
    made = house(wall(), Elements("B01/F1", (), (protrusion("cornice", (-1, 3.1, 1, 3.3), -0.2),)))
    assert len(made.installations) == 1 and not made.failed
    made = house(wall(), Elements("B01/F1", (), (protrusion("cornice", (-1, 5.1, 1, 5.3), -0.2),)))
    assert [f.code for f in made.failed] == ["S310"]


def test_the_model_is_the_host_and_its_offset_is_reported():
    coarse = house(wall(at=(0, 0.3, 0)), Elements("B01/F1", ()))
    shell = Shell("2", tuple(polygons(coarse.built[0].host)))
    building = Building("B01", np.arange(3), GROUND)
    front = (wall(), Elements("B01/F1", (window("W1", (-1, -1, 1, 1)),)))
    made = assemble(building, [front], [shell], WORLD)
    assert isinstance(made, Assembled) and made.coarse.source == "model"
    assert made.built[0].offsets["W1"] == pytest.approx(0.3, abs=1e-3)
    seated = assemble(building, [front], [shell], WORLD, BuildOptions(reseat=True))
    assert isinstance(seated, Assembled) and seated.built[0].offsets["W1"] == pytest.approx(0.0, abs=1e-3)


def test_a_model_far_from_the_facade_is_not_used():
    far = house(wall(at=(0, 5.0, 0)), Elements("B01/F1", ()))
    shell = Shell("2", tuple(polygons(far.built[0].host)))
    made = assemble(Building("B01", np.arange(3), GROUND), [(wall(), Elements("B01/F1", ()))], [shell], WORLD)
    assert isinstance(made, Assembled) and made.coarse.source == "cloud"
    assert "no wall of the city model is within 1 m" in made.notes[0]


@pytest.mark.parametrize("height", [-3.2, -400.0])
def test_a_footprint_alone_is_extruded_to_the_height_of_the_facade(height):
    """The height of the footprint does not matter; footprints from maps have none."""
    foot = np.array([[-5, 0, height], [5, 0, height], [5, 9, height], [-5, 9, height]])
    ring = wall().frame.apply(foot)
    model = CityBuilding("M", (Shell("0", (Surface(ring, "GroundSurface"),)),))
    assert match_model({"B01": [wall()]}, [model], BuildOptions()) == (ModelMatch(("B01",), ("M",)),)
    shell = Shell("0", (polygons(house(wall(), Elements("B01/F1", ())).built[0].host)[0],))
    shell = replace(shell, surfaces=(replace(shell.surfaces[0], ring=ring, semantics="GroundSurface"),))
    made = assemble(Building("B01", np.arange(3), GROUND), [(wall(), Elements("B01/F1", ()))], [shell], WORLD)
    assert isinstance(made, Assembled) and made.coarse.source == "model"
    assert volume6(made.built[0].host) / 6e12 == pytest.approx(10 * 9 * 6.2, rel=1e-3)


def test_a_facade_measured_with_the_house_next_door_goes_to_the_wall_that_it_stands_on():
    """The neighbour's jetty, 1.6 m before its wall in the model, was taken for the house's own."""
    feet = {"M1": (-5.0, 5.0), "M2": (5.0, 15.0)}
    model = [
        CityBuilding(name, (Shell("0", (Surface(wall().frame.apply(foot), "GroundSurface"),)),))
        for name, (a, b) in feet.items()
        for foot in [np.array([[a, 0, -3.2], [b, 0, -3.2], [b, 9, -3.2], [a, 9, -3.2]])]
    ]
    jetty = replace(wall(wide=4.0, at=(9.0, -1.6, 0.0)), id="B01/F2")
    next_door = replace(wall(at=(10.0, 0.0, 0.0)), id="B02/F1")
    facades = {"B01": [replace(wall(), id="B01/F1"), jetty], "B02": [next_door]}
    matches = match_model(facades, model, BuildOptions())
    assert [m.model for m in matches] == [("M1",), ("M2",)]
    found = facades_of_matches(facades, matches, model, BuildOptions())
    assert found == [("B01/F1",), ("B01/F2", "B02/F1")]
    alone = match_model(facades, model[:1], BuildOptions())
    assert facades_of_matches(facades, alone, model[:1], BuildOptions()) == [
        ("B01/F1", "B01/F2"),
        ("B02/F1",),
    ]


def test_nothing_to_build_from():
    made = assemble(Building("B01", np.arange(3), GROUND), [], [], WORLD)
    assert isinstance(made, Failed) and made.code == "S305"


@pytest.mark.parametrize("turn", [np.pi / 2, -np.pi / 2, 1.2, -1.0])
@pytest.mark.parametrize("gap", [0.0, 0.4])
def test_two_facades_meet_at_their_corner(turn, gap):
    """At an outer and at an inner corner: one block with both walls in their planes."""
    one = wall(at=(-5.0 - gap, 0.0, 0.0))
    side = 5.0 + gap if turn > 0 else -5.0 - gap
    f = wall(turn=0.7 + turn)
    end = wall().frame.t  # the corner of both planes
    pose = replace(f.frame, t=end + f.frame.R @ np.array([side * np.sign(turn), 0, 0]))
    other = replace(f, id="B01/F2", local_from_facade=Estimate(pose, np.eye(6) * 1e-8, 9.0))
    panes = [window(f"W{k}", (-2, -1, 0, 1)) for k in (1, 2)]
    fronts = [(one, Elements("B01/F1", (panes[0],))), (other, Elements("B01/F2", (panes[1],)))]
    made = assemble(Building("B01", np.arange(3), GROUND), fronts, (), WORLD)
    assert isinstance(made, Assembled) and len(made.built) == 1 and not made.failed
    assert not validate(made.built[0].solid)
    assert [len(faces(made, f"W{k}")) for k in (1, 2)] == [1, 1]
    assert max(abs(v) for v in made.built[0].offsets.values()) < 1e-3


def test_front_and_back_of_a_shallow_house_are_one_block():
    back = wall(turn=0.7 + np.pi)
    pose = replace(back.frame, t=wall().frame.apply(np.array([[0, 5.0, 0]]))[0])
    other = replace(back, id="B01/F2", local_from_facade=Estimate(pose, np.eye(6) * 1e-8, 9.0))
    fronts = [(wall(), Elements("B01/F1", ())), (other, Elements("B01/F2", ()))]
    made = assemble(Building("B01", np.arange(3), GROUND), fronts, (), WORLD)
    assert isinstance(made, Assembled)
    assert volume6(made.built[0].host) / 6e12 == pytest.approx(10 * 5 * 6.2, rel=1e-3)


def test_a_ragged_outline_becomes_a_clean_gable():
    rng = np.random.default_rng(1)
    x = np.arange(-5, 5.01, 0.1)
    gable = 3 - np.abs(x) * 0.6 + rng.uniform(0, 0.1, len(x))
    ring = np.column_stack([x, gable])[::-1]
    outline = np.concatenate([[[-5, -3], [0, -2.8], [5, -3]], ring])
    clean = clean_outline(replace(wall(), outline=outline), GROUND)
    assert len(clean) == 5
    assert clean[:, 1].min() == pytest.approx(-3.2) and clean[:, 1].max() == pytest.approx(3.05, abs=0.1)


def test_a_window_in_the_cheek_of_an_oriel():
    """The side of a protrusion is a wall like any other for a facade that was measured on it."""
    front = wall()
    bay = protrusion("oriel", (-2, -1, 2, 2), -1.5)
    cheek = wall(turn=0.7 + np.pi / 2)
    pose = replace(cheek.frame, t=front.frame.apply(np.array([[2.0, -0.75, 0.5]]))[0])
    if (pose.R[:, 1] @ front.frame.R[:, 0]) > 0:  # its inside lies to the left
        cheek = wall(turn=0.7 - np.pi / 2)
        pose = replace(cheek.frame, t=pose.t)
    cheek = replace(
        cheek,
        id="B01/F2",
        local_from_facade=Estimate(pose, np.eye(6) * 1e-8, 9.0),
        outline=rectangle(-0.7, -1.4, 0.7, 1.4),
    )
    fronts = [
        (cheek, Elements("B01/F2", (window("W2", (-0.4, -0.5, 0.4, 0.7), 0.15),))),
        (front, Elements("B01/F1", (window("W1", (-1, 0, 1, 1.5), 0.2),), (bay,))),
    ]
    shell = Shell("2", tuple(polygons(house(front, Elements("B01/F1", ())).built[0].host)))
    made = assemble(Building("B01", np.arange(3), GROUND), fronts, [shell], WORLD)
    assert isinstance(made, Assembled) and not made.failed
    assert not validate(made.built[0].solid)
    gain = volume6(made.built[0].solid) - volume6(made.built[0].host)
    assert gain / 6e12 == pytest.approx(4 * 3 * 1.5 - 2 * 1.5 * 0.2 - 0.8 * 1.2 * 0.15, abs=5e-3)
