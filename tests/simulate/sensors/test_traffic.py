"""Cars and pedestrians that move between the photographs and the scan."""

import numpy as np
import pytest

from frontage.simulate.scene import Part, Scene
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.sensors.traffic import with_moved_traffic
from frontage.simulate.spec import parse_spec
from frontage.simulate.street.build import build_street


@pytest.fixture(scope="module")
def street() -> Scene:
    return build_street(
        parse_spec("seed = 5\nhouses = 3\nstreet_width = 17\nslope = 4.0\ncars = 6\npeople = 6\ntrees = 2")
    )


def things(scene: Scene) -> dict[str, np.ndarray]:
    """Points (n, 3) m, street frame, of every car and pedestrian."""
    found: dict[str, list[np.ndarray]] = {}
    for k, surface in enumerate(scene.surfaces):
        if surface.part in (Part.CAR, Part.PERSON):
            corners = scene.mesh.corners[scene.mesh.surface == k].ravel()
            found.setdefault(surface.id.split("/")[0], []).append(scene.mesh.vertices[corners])
    inverse = scene.local_from_street.inverse
    return {name: inverse.apply(np.concatenate(parts)) for name, parts in found.items()}


def test_moved_things_keep_their_shape_and_stay_on_the_ground(street):
    before, after = things(street), things(with_moved_traffic(street, 1.0, 1))
    gone = [name for name in before if not len(after[name])]
    assert len(before) >= 8 and 0 < len(gone) < len(before)
    for name in set(before) - set(gone):
        shift = after[name] - before[name]
        assert np.ptp(shift, axis=0).max() < 1e-9  # nothing is left behind, nothing is bent
        assert 1.5 <= abs(shift[0, 0]) <= 12 and abs(shift[0, 1]) < 1e-9
        assert shift[0, 2] == pytest.approx(0.04 * shift[0, 0], abs=1e-6)


def test_everything_else_stays(street):
    moved = with_moved_traffic(street, 1.0, 1)
    assert moved.surfaces is street.surfaces

    def rest(scene: Scene) -> np.ndarray:
        still = ~np.isin(scene.parts[scene.mesh.surface], (Part.CAR, Part.PERSON))
        return scene.mesh.vertices[scene.mesh.corners[still]]

    np.testing.assert_allclose(rest(moved), rest(street), atol=1e-9)


def test_the_share_is_kept_and_the_seed_decides(street):
    assert with_moved_traffic(street, 0.0, 1) is street
    counts, before = [], things(street)
    for seed in range(12):
        after = things(with_moved_traffic(street, 0.3, seed))
        same = [len(after[n]) and np.abs(after[n] - before[n]).max() < 1e-6 for n in before]
        counts.append(1 - np.mean(same))
    assert np.mean(counts) == pytest.approx(0.3, abs=0.12) and np.std(counts) > 0
    one, two = (with_moved_traffic.__wrapped__(street, 0.5, 7) for _ in range(2))
    np.testing.assert_array_equal(one.mesh.vertices, two.mesh.vertices)
    np.testing.assert_array_equal(one.mesh.corners, two.mesh.corners)


def test_moved_things_do_not_stand_in_one_another_or_on_a_tripod(street):
    clear = tuple((float(x), float(y)) for x, y in street.road[::2, :2])
    stations = street.local_from_street.inverse.apply(street.road[::2])[:, :2]
    for seed in range(5):
        moved = with_moved_traffic(street, 1.0, seed, clear)
        before, after = things(street), things(moved)
        boxes = {n: (p[:, :2].min(0), p[:, :2].max(0)) for n, p in after.items() if len(p)}
        for name, (low, high) in boxes.items():
            if np.abs(after[name] - before[name]).max() < 1e-6:
                continue
            assert not ((stations > low) & (stations < high)).all(1).any()
            others = [box for other, box in boxes.items() if other != name]
            assert not any((low < top).all() and (high > bottom).all() for bottom, top in others)


def test_a_scan_sees_the_traffic_of_its_own_time(street):
    seen = {}
    for moved in (0.0, 1.0):
        spec = ScannerSpec(stations=1, spacing=0.25, colour=False, moved=moved, strays=0.0)
        (s,) = scan_stations(street, spec, 1)
        car = np.array([k for k, x in enumerate(street.surfaces) if x.part == Part.CAR])
        on_car = np.isin(s.surface, car)
        plain = on_car & (s.echo == 0)
        seen[moved] = street.local_from_street.inverse.apply(s.scan.xyz[plain])
    corners = np.concatenate(list(things(street).values()))

    def away(xyz: np.ndarray) -> np.ndarray:
        return np.array([np.linalg.norm(corners - p, axis=1).min() for p in xyz[::5]])

    assert np.median(away(seen[0.0])) < 0.3 and np.quantile(away(seen[1.0]), 0.75) > 1.0
