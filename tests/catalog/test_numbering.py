"""Floors, bays and ids: of simulated houses with their true numbers, and of fronts that are hard to count."""

import json
import random

import numpy as np
import pytest

from frontage.catalog import number_building, number_facade
from frontage.model import Elements, Opening
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from numbered_fronts import facade, opening, rows
from realdata import data_path


def floors(openings: tuple[Opening, ...]) -> list[int]:
    """The floor of every opening, from below."""
    return [o.floor for o in sorted(openings, key=lambda o: (o.ring[:, 1].mean(), o.ring[:, 0].min()))]


@pytest.fixture(scope="module")
def houses() -> list[tuple[str, float, list[Opening], list[tuple[int, str]]]]:
    """Fronts of simulated houses: id, ground, openings without names, true floors and ids."""
    out = []
    for seed, setting in ((0, "terrace"), (1, "terrace"), (2, "detached")):
        table = {
            "seed": 900 + seed,
            "houses": 6,
            "opposite": False,
            "setting": setting,
            "cars": 0,
            "trees": 0,
        }
        for house in build_street(SceneSpec.model_validate(table)).houses:
            for front in house.facades:
                plain = [
                    opening(o.ring[:, 0].min(), o.ring[:, 1].min(), *np.ptp(o.ring, axis=0), o.kind)
                    for o in front.openings
                ]
                ground = house.ground_z - float(front.local_from_facade.t[2])
                out.append((front.id, ground, plain, [(o.floor, o.id) for o in front.openings]))
    return out


@pytest.mark.parametrize("known", [True, False], ids=["ground known", "ground not known"])
def test_simulated_houses_get_their_true_numbers(houses: list, known: bool) -> None:
    right = total = 0
    for id, ground, plain, truth in houses:
        found = number_facade(id, plain, ground if known else None)
        names = {o.ring.tobytes(): (o.floor, o.id) for o in found}
        right += sum(names[o.ring.tobytes()] == true for o, true in zip(plain, truth, strict=True))
        total += len(plain)
    assert total > 300
    assert right >= 0.98 * total


def test_numbers_survive_a_third_of_the_openings_missing(houses: list) -> None:
    right = total = 0
    chance = random.Random(5)
    for id, ground, plain, truth in houses:
        kept = [k for k in range(len(plain)) if chance.random() > 0.35]
        found = {o.ring.tobytes(): o.floor for o in number_facade(id, [plain[k] for k in kept], ground)}
        right += sum(found[plain[k].ring.tobytes()] == truth[k][0] for k in kept)
        total += len(kept)
    assert right >= 0.98 * total


def test_the_order_of_the_openings_does_not_matter(houses: list) -> None:
    id, ground, plain, _ = max(houses, key=lambda h: len(h[2]))
    mixed = random.Random(1).sample(plain, len(plain))
    first, second = number_facade(id, plain, ground), number_facade(id, mixed, ground)
    assert [(o.id, o.bay, o.ring.tobytes()) for o in first] == [
        (o.id, o.bay, o.ring.tobytes()) for o in second
    ]
    assert len({o.id for o in first}) == len(plain)


def test_a_row_that_was_not_seen_keeps_its_number() -> None:
    assert floors(number_facade("B01/F1", rows([1.0, 4.1, 10.3]), 0.0)) == [0] * 3 + [1] * 3 + [3] * 3


def test_a_blank_ground_floor_keeps_its_number() -> None:
    assert floors(number_facade("B01/F1", rows([4.9, 8.0]), 0.0)) == [1] * 3 + [2] * 3


def test_windows_of_a_staircase_do_not_move_the_floors() -> None:
    stairs = [opening(7.0, z) for z in (2.6, 5.7, 8.8)]
    found = number_facade("B01/F1", [*rows([1.0, 4.1, 7.2, 10.3]), *stairs], 0.0)
    assert [o.floor for o in found if o.ring[:, 0].min() < 7.0] == sorted([0, 1, 2, 3] * 3)
    assert [o.floor for o in found if o.ring[:, 0].min() == 7.0] in ([0, 1, 2], [1, 2, 3])


def test_a_mezzanine_counts_and_a_fanlight_does_not() -> None:
    low = [
        opening(1.0, 0.1, 1.2, 2.1, "door"),
        opening(1.0, 2.3, 1.2, 0.5),
        opening(3.5, 0.4, 2.5, 2.4, "shopfront"),
    ]
    mezzanine = rows([3.7], h=1.2)
    found = number_facade("B01/F1", [*low, *mezzanine, *rows([6.2, 9.4])], 0.0)
    assert floors(found) == [0] * 3 + [1] * 3 + [2] * 3 + [3] * 3


def test_basement_windows_are_below_the_ground_floor_whatever_they_are_called() -> None:
    cellar = [opening(1.1, 0.3, 0.8, 0.4, "basement"), opening(3.1, 0.3, 0.8, 0.4)]
    door = opening(5.0, 0.1, 1.1, 2.7, "door")
    found = number_facade("B01/F1", [*cellar, *rows([1.9], (1.0, 3.0)), door, *rows([5.1])], 0.0)
    assert [o.id.split("/")[2] for o in found] == [
        "B-1-1", "W-1-2", "W0-1", "W0-2", "D0-3", "W1-1", "W1-2", "W1-3",
    ]  # fmt: skip


def test_an_oculus_over_the_door_belongs_to_the_ground_floor() -> None:
    door = [opening(3.0, 0.1, 1.0, 2.2, "door"), opening(3.2, 2.7, 0.6, 0.6)]
    found = number_facade("B01/F1", [*door, *rows([1.1, 4.5], (1.0, 5.0))], 0.0)
    assert floors(found) == [0] * 4 + [1] * 2


def test_a_stair_hall_of_two_storeys_belongs_to_its_lower_floor() -> None:
    hall = opening(7.0, 0.3, 1.5, 5.6)
    found = number_facade("B01/F1", [*rows([1.0, 4.1, 7.2]), hall], 0.0)
    assert next(o.floor for o in found if o.ring[:, 0].min() == 7.0) == 0
    assert [o.floor for o in found if o.ring[:, 0].min() < 7.0] == [0] * 3 + [1] * 3 + [2] * 3


def test_a_tower_counts_to_its_top() -> None:
    found = number_facade("B01/F1", rows(1.0 + 3.0 * np.arange(30), 1.0 + 2.0 * np.arange(12)), 0.0)
    assert floors(found) == sorted(list(range(30)) * 12)


def test_bays_are_columns_over_all_floors_and_numbers_count_within_one() -> None:
    shop = opening(0.8, 0.3, 3.4, 2.6, "shopfront")
    found = number_facade("B01/F1", [shop, *rows([4.1, 7.2]), opening(3.0, 10.3), opening(5.0, 10.3)], 0.0)
    by_name = {o.id.split("/")[2]: o.bay for o in found}
    assert by_name["W1-2"] == by_name["W2-2"] == by_name["W3-1"] == 2
    assert by_name["W3-2"] == 3
    assert by_name["S0-1"] in (1, 2)
    assert max(by_name.values()) == 3


def test_shops_that_match_no_window_leave_the_windows_their_bays() -> None:
    shops = [opening(x, 0.3, 2.2, 2.6, "shopfront") for x in (0.4, 3.2, 6.0)]
    found = number_facade("B01/F1", [*shops, *rows([4.1], (0.6, 2.2, 3.8, 5.4, 7.0))], 0.0)
    assert [o.bay for o in found if o.floor == 1] == [1, 2, 3, 4, 5]
    assert max(o.bay for o in found) == 5


@pytest.mark.parametrize("ground", [0.0, None])
def test_no_opening_and_a_single_one(ground: float | None) -> None:
    assert number_facade("B01/F1", [], ground) == ()
    (found,) = number_facade("B01/F1", [opening(1.0, 1.0)], ground)
    assert (found.id, found.floor, found.bay) == ("B01/F1/W0-1", 0, 1)


def test_floors_agree_between_the_facades_of_a_building() -> None:
    """The back shows its upper floors only: its rows are those of the front."""
    front, back = facade("B01/F1", (0.0, 0.0, 100.0)), facade("B01/F2", (8.0, 9.0, 104.0), 270.0)
    high = [opening(1.0, z - 4.0) for z in (7.2, 10.3)]
    elements = [Elements("B01/F1", tuple(rows([1.0, 4.1, 7.2, 10.3]))), Elements("B01/F2", tuple(high))]
    first, second = number_building([front, back], elements, 100.0)
    assert floors(first.openings) == sorted([0, 1, 2, 3] * 3)
    assert [o.id for o in second.openings] == ["B01/F2/W2-1", "B01/F2/W3-1"]


def test_a_split_level_has_floors_of_its_own() -> None:
    front, wing = facade("B01/F1"), facade("B01/F2", (20.0, 0.0, 0.0))
    elements = [
        Elements("B01/F1", tuple(rows([1.0, 4.0, 7.0, 10.0, 13.0], h=1.8))),
        Elements("B01/F2", tuple(rows([2.5, 5.5, 8.5, 11.5], (1.0, 3.0), h=1.8))),
    ]
    first, second = number_building([front, wing], elements, 0.0)
    assert floors(first.openings) == sorted([0, 1, 2, 3, 4] * 3)
    assert floors(second.openings) == sorted([0, 1, 2, 3] * 2)


def test_unknown_ground_is_inferred_from_the_openings() -> None:
    front = facade("B01/F1", (0.0, 0.0, 50.0))
    elements = [Elements("B01/F1", (opening(1.0, 0.1, 1.0, 2.2, "door"), *rows([4.1, 7.2])))]
    (found,) = number_building([front], elements, float("nan"))
    assert floors(found.openings) == [0] + [1] * 3 + [2] * 3


@pytest.mark.parametrize(
    ("front", "lowest", "most"), [("brooklyn_row", 0, 2), ("manhattan_apartment", 1, 15)]
)
def test_rows_of_real_fronts_are_counted_as_their_annotator_did(front: str, lowest: int, most: int) -> None:
    table = json.loads(data_path(f"truth/{front}.json").read_text())
    told = {}
    for o in table["openings"]:
        one = opening(o["x0"], o["z0"], o["x1"] - o["x0"], o["z1"] - o["z0"], o["kind"])
        told[one.ring.tobytes()] = (one, o["floor"] - lowest)
    found = number_facade("B01/F1", [one for one, _ in told.values()])
    assert [o.floor for o in found] == [told[o.ring.tobytes()][1] for o in found]
    assert max(o.floor for o in found) == most - lowest


def test_high_storeys_are_not_counted_as_two() -> None:
    """Nine equal rows 5 m apart: many empty storeys are less likely than high ones."""
    found = number_facade("B01/F1", rows(1.2 + 5.0 * np.arange(9), h=1.5), 0.0)
    assert floors(found) == sorted(list(range(9)) * 3)
