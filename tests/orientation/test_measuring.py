"""Control of one photo: templates are as large, and drawings as coarse, as precise points take."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from frontage.orientation import control, measuring
from frontage.orientation.control import find_control
from frontage.orientation.measuring import Agreement, Search, agreement, measured_control
from frontage.orientation.reflectance.surface import scanned_surface
from frontage.orientation.result import MANY
from frontage.orientation.templates import HALF
from orientation.paintedwalls import Wall, looking, photograph, posed, scan_of, windows

SEARCH = Search(6, 12, 2 * HALF)
FRONT = (Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), windows(14.0, 9.0)),)


def seen(step):
    """A photo of a front, and its scan with `step` m between points, as control is looked for in them."""
    photo = posed(looking(6.0, -8.0))
    picture = photograph(FRONT, photo)
    return photo, scanned_surface(scan_of(FRONT, step)), lambda _: picture


def usual(how):
    return find_control(*how, radius=SEARCH.radius, step=SEARCH.step, largest=SEARCH.largest).telling()


@pytest.mark.parametrize(("asked", "wider"), [(0.7, 1), (0.1, 2)])
def test_templates_grow_until_points_are_as_precise_as_is_asked(monkeypatch, asked, wider):
    monkeypatch.setattr(measuring, "PRECISE_PX", asked)
    how = seen(0.03)
    found, others = measured_control(*how, SEARCH), usual(how)
    half = (np.median(others.side) - 1.0) / 2.0
    assert np.median(found.side) == pytest.approx(2.0 * wider * half + 1.0, rel=0.01)
    assert agreement(found).rms <= asked
    assert len(found) >= MANY


def test_small_templates_stay_small_whatever_is_asked(monkeypatch):
    monkeypatch.setattr(measuring, "PRECISE_PX", 0.01)
    found = measured_control(*seen(0.03), Search(12, 24))
    assert np.median(found.side) == 2.0 * HALF + 1.0


def test_templates_of_shape_alone_stay_as_they_are(monkeypatch):
    monkeypatch.setattr(measuring, "PRECISE_PX", 0.01)
    tried = []

    def found(*_, wider, **__):
        tried.append(wider)
        return SimpleNamespace(telling=lambda: None)

    monkeypatch.setattr(measuring, "find_control", found)
    photo, surface, image_of = seen(0.1)
    measured_control(photo, replace(surface, tone=None, kind="geometry"), image_of, SEARCH)
    assert tried == [1]


def test_points_that_lie_unevenly_are_drawn_coarser_than_their_spacing_asks(monkeypatch):
    # Every fourth point, as chance has it, so that the finest drawing has holes of all sizes.
    photo, _, image_of = seen(0.03)
    scan = scan_of(FRONT, 0.03)
    some = np.flatnonzero(np.random.default_rng(0).random(len(scan)) < 0.25)
    how = photo, scanned_surface(scan.take(some)), image_of
    found = agreement(measured_control(*how, SEARCH))
    assert found.count >= MANY and found.rms < 0.5
    monkeypatch.setattr(control, "_COARSEST", 1.0)
    assert agreement(measured_control(*how, SEARCH)).count < MANY


def test_many_precise_points_are_better_than_many_and_many_better_than_few():
    many, precise, few = Agreement(300, 0.9, 9), Agreement(200, 0.6, 9), Agreement(150, 0.2, 9)
    assert precise.better_than(many) and not many.better_than(precise)
    assert many.better_than(few) and not few.better_than(precise)


def test_enough_points_are_precise_only_if_their_rms_is_known_to_be_small():
    assert Agreement(200, 0.65, 100).surely_precise
    assert not Agreement(200, 0.65, 4).surely_precise  # 0.65 with a standard error of 0.16 px
    assert not Agreement(199, 0.2, 100).surely_precise
