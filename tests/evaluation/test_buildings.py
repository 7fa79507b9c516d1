"""Scoring of the split into buildings."""

import numpy as np
import pytest

from frontage.evaluation.buildings import score_buildings
from frontage.evaluation.result import LabelledPoints
from frontage.evaluation.truth import read_truth
from truth_tables import HEIGHT, WIDTH, axes, table, truth


def street(cut: float | None, swapped: float = 0.0) -> tuple[LabelledPoints, int]:
    """Points of both houses' walls; the split puts all left of `cut` m into one building, None: all."""
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 2 * WIDTH, 20_000)
    xyz = np.column_stack([x, rng.normal(0, 0.005, len(x)), rng.uniform(0, HEIGHT, len(x))]) @ axes().T
    house = (x > WIDTH).astype(np.int64)
    found = np.zeros(len(x), np.int64) if cut is None else (x > cut).astype(np.int64)
    found = np.where(rng.random(len(x)) < swapped, -1, found)
    names = ("B01",) if cut is None else ("B01", "B02")
    return LabelledPoints(xyz, house, found, names), len(names)


@pytest.mark.parametrize(("cut", "error"), [(WIDTH, 0.0), (WIDTH + 0.3, 0.3), (WIDTH - 0.12, 0.12)])
def test_a_split_is_found_and_its_cut_measured(cut: float, error: float) -> None:
    f = score_buildings(truth(), *street(cut)).figures
    assert f["f1"].value == 1.0 and f["cuts_found"].value == 1.0
    assert f["cut_median"].value == pytest.approx(error, abs=0.01)


def test_two_houses_merged_into_one_are_not_found() -> None:
    part = score_buildings(truth(), *street(None))
    f = part.figures
    assert f["recall"].value == pytest.approx(0.5) and f["cuts_found"].value == 0.0
    assert f["cut_median"].value is None and f["count"].value == 1


def test_a_house_cut_in_two_reduces_precision() -> None:
    points, _ = street(WIDTH)
    third = np.where((points.found == 1) & (points.house == 1) & (points.xyz[:, 2] > 5), 2, points.found)
    scored = score_buildings(
        truth(), LabelledPoints(points.xyz, points.house, third, ("B01", "B02", "B03")), 3
    )
    assert scored.figures["precision"].value == pytest.approx(2 / 3)
    assert {"found": "B03", "matched": None} in scored.items


def test_points_without_a_building_reduce_the_overlap() -> None:
    f = score_buildings(truth(), *street(WIDTH, swapped=0.6)).figures
    assert f["iou"].value == pytest.approx(0.4, abs=0.02) and f["f1"].value == 0.0


def test_houses_that_no_sensor_saw_do_not_count() -> None:
    houses = table()
    houses["facades"][1]["visible"] = {"stations": 0.1, "photos": 0.9, "any": 0.9}
    points, _ = street(None)
    own = LabelledPoints(points.xyz[points.house == 0], np.zeros((points.house == 0).sum()),
                         np.zeros((points.house == 0).sum()), ("B01",))  # fmt: skip
    f = score_buildings(read_truth(houses), own, 1, ("stations",)).figures
    assert f["f1"].value == 1.0 and f["recall"].n == 1 and f["cuts_found"].n == 0
    assert score_buildings(read_truth(houses), own, 1).figures["recall"].value == 0.5
