"""Varied windows: the plans tell what is drawn, and the regular ones stay as they were."""

from collections import Counter
from functools import lru_cache

import numpy as np
import pytest

pytest.importorskip("embreex")

from frontage.evaluation.truth import read_truth
from frontage.geometry.ring import rectangle
from frontage.simulate.houses.designs import draw_design
from frontage.simulate.houses.glazing import Design, Field, divide, least_pane, panes
from frontage.simulate.houses.shapes import opening_ring
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import OpeningPlan, Part, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.truth.tables import scene_table
from frontage.simulate.truth.visibility import visibility

SEEDS = (0, 1, 2, 5)


@lru_cache
def scene_of(seed: int, windows: str = "varied") -> Scene:
    house = {"windows": windows, "shutters": False, "floors": 4, "width": 13.0, "oriel": False}
    keys = {"seed": seed, "house": [house, house], "opposite": False, "setting": "terrace"}
    return build_street(
        SceneSpec.model_validate(keys | dict.fromkeys(("trees", "cars", "lamps", "people"), 0))
    )


def windows(seed: int) -> list[tuple[int, OpeningPlan]]:
    return [(k, o) for k, h in enumerate(scene_of(seed).houses) for o in h.facades[0].openings if o.glazed]


@pytest.mark.parametrize("seed", SEEDS)
def test_rays_find_every_bar_where_the_plan_says_and_glass_between_the_bars(seed: int) -> None:
    scene, met = scene_of(seed), Counter[str]()
    tracer = Tracer(scene.mesh)
    for house, plan in windows(seed):
        frame = scene.houses[house].facades[0].local_from_facade

        def look(x: float, z: float) -> tuple[int, float]:
            start = frame.apply(np.array([[x, plan.wall_y - 0.3, z]]))  # noqa: B023
            hit = tracer.first_hit(start, frame.rotate(np.array([[0.0, 1.0, 0.0]])))  # noqa: B023
            depth = float(hit.distance[0]) - 0.3 - plan.depth  # noqa: B023
            return int(scene.parts[scene.mesh.surface[hit.triangle[0]]]), depth

        for bar in plan.bars:
            middle = bar.extent[0] + 0.37 * (bar.extent[1] - bar.extent[0])
            for across in (-0.45 * bar.width, 0.0, 0.45 * bar.width):
                at = (bar.position + across, middle)
                part, depth = look(*(at if bar.axis == "vertical" else at[::-1]))
                assert part == Part.BAR, plan.id
                assert bar.behind - 1e-6 <= depth <= bar.behind + 0.017, plan.id
            met[bar.axis] += 1
        for line in plan.lines[::7]:
            (xa, za), (xb, zb) = line.line
            part, _ = look(xa + 0.41 * (xb - xa), za + 0.41 * (zb - za))
            assert part == Part.BAR, plan.id
    assert min(met["vertical"], met["horizontal"]) > 10


def test_the_lower_sash_stands_behind_the_upper_one() -> None:
    sashes = [o for seed in SEEDS for _, o in windows(seed) if o.meeting is not None]
    assert len(sashes) > 5
    for plan in sashes:
        assert plan.meeting is not None
        for bar in plan.bars:
            if bar.axis == "vertical":
                low = sum(bar.extent) / 2 < plan.meeting
                assert bar.behind == pytest.approx(0.065 if low else 0.025)


def test_designs_have_as_many_panes_as_those_of_real_streets() -> None:
    rng = np.random.default_rng(3)
    counts = []
    for _ in range(800):
        ring = opening_ring("rectangle", 0, 0, float(rng.uniform(0.9, 1.5)), float(rng.uniform(1.3, 2.2)))
        design = draw_design(ring, 0.07, rng)
        width, height = np.ptp(ring, axis=0) - 0.14
        assert least_pane(design.field, width, height) >= 0.13
        counts.append(99 if design.leads else panes(design.field))
    share = np.array([np.mean(np.isin(counts, range(a, b))) for a, b in
                      ((1, 2), (2, 3), (3, 4), (4, 5), (5, 7), (7, 13), (13, 100))])  # fmt: skip
    real = np.array([0.08, 0.152, 0.114, 0.148, 0.148, 0.218, 0.14])  # WinSyn, the rest among 5 to 12
    np.testing.assert_allclose(share, real, atol=0.06)


def test_a_cross_window_is_told_by_its_bars() -> None:
    casements = Field((0.5,), width=0.1)
    design = Design(Field(horizontal=(0.7,), width=0.08, parts=(casements, Field(horizontal=(0.5,)))))
    bars = divide(rectangle(0, 0, 1.2, 2.1), 0.1, design).bars
    told = [(b.axis, round(b.position, 3), tuple(round(e, 3) for e in b.extent), b.behind) for b in bars]
    assert told == [
        ("horizontal", 1.43, (0.1, 1.1), 0.0),
        ("vertical", 0.6, (0.1, 1.43), 0.0),
        ("horizontal", 1.715, (0.1, 1.1), 0.018),
    ]


def test_bars_in_an_arched_head_end_at_its_curve_and_spokes_are_told_apart() -> None:
    ring = opening_ring("round", 0, 0, 1.2, 2.0)
    division = divide(ring, 0.1, Design(Field((0.5,), width=0.08), spokes=3))
    assert division.glazing == "radial" and len(division.lines) == 3
    assert [(b.axis, round(b.position, 2)) for b in division.bars] == [("horizontal", 1.4), ("vertical", 0.6)]
    for line in division.lines:
        start, end = np.array(line.line)
        np.testing.assert_allclose(np.linalg.norm(end - start), 0.5, atol=2e-3)
    upright = divide(ring, 0.1, Design(Field((0.25,)))).bars[0]
    assert upright.extent[1] == pytest.approx(1.4 + np.sqrt(0.5**2 - 0.25**2), abs=2e-3)


def test_varied_windows_are_deterministic_and_leave_the_rest_of_a_house_as_it_is() -> None:
    again = scene_of.__wrapped__(1)
    np.testing.assert_array_equal(again.mesh.vertices, scene_of(1).mesh.vertices)
    regular = scene_of(1, "regular").houses[0].facades[0].openings
    varied = scene_of(1).houses[0].facades[0].openings
    assert [o.id for o in regular] == [o.id for o in varied]
    for a, b in zip(regular, varied, strict=True):
        np.testing.assert_array_equal(a.ring, b.ring)
    assert {o.glazing for o in regular} == {"bars"} and not any(o.lines or o.meeting for o in regular)
    assert any(a.bars != b.bars for a, b in zip(regular, varied, strict=True))


def test_the_truth_tells_glazing_lines_and_depths_and_is_read_again() -> None:
    scene = scene_of(3)
    table = scene_table(scene, visibility(scene, Tracer(scene.mesh), [], np.empty((0, 3)), []), {})
    read = read_truth(table | {"stations": [], "photos": [], "points": [], "drive": None})
    built = {o.id: o for h in scene.houses for f in h.facades for o in f.openings}
    found = [o for f in read.facades for o in f.openings]
    assert len(found) == len(built)
    for opening in found:
        plan = built[opening.id]
        assert opening.glazing == plan.glazing and len(opening.lines) == len(plan.lines)
        behind = sorted(b.behind for b in opening.bars)
        np.testing.assert_allclose(behind, sorted(b.behind for b in plan.bars), atol=1e-6)
    assert any(o.lines for o in found)
