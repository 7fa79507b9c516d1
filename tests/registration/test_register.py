"""`register` against simulated truth: accuracy, covariance, observability, clear errors."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.errors import CrsError, InputError
from frontage.geometry.arrays import Array
from frontage.geometry.rigid import rotation_angle
from frontage.model import CityModel, Estimate, WorldRef
from frontage.registration import (
    PosePrior,
    RegisteredScan,
    Registration,
    RegistrationOptions,
    prior_of,
    register,
)
from registration.boxes import ALONE, STREET, WORLD, BoxHouse, MisplacedScan, misplaced, model_of, scan_of

PLACE = np.array([0.0, 0.0, 1.7])
EXACT = RegistrationOptions(sigma_model=0.001, sigma_height=0.001, sigma_lean=0.01)


def run(given: list[MisplacedScan], model: CityModel, options: RegistrationOptions = EXACT) -> Registration:
    return register([g.scan for g in given], model, [g.prior for g in given], options)


def error(result: RegisteredScan, given: MisplacedScan) -> tuple[Array, float]:
    """Error of the instrument's place (3,) m, and of the rotation, rad."""
    R = result.local_from_given.value.R
    true = given.true.apply(given.prior.position[None])[0]
    return result.position - true, rotation_angle(R @ given.true.R.T)


@pytest.mark.parametrize("heading", [-15.0, 0.0, 15.0])
def test_a_scan_five_metres_and_fifteen_degrees_off_is_placed(heading: float) -> None:
    shift = 5.0 * np.array([np.cos(heading), np.sin(heading), 0.1])
    given = misplaced(scan_of(STREET, PLACE), shift, heading, level=0.1)
    result = run([given], model_of(STREET))
    off, angle = error(result.scans[0], given)
    assert np.linalg.norm(off[:2]) < 0.005
    assert abs(off[2]) < 0.05
    assert angle < np.radians(0.05)
    assert not result.ambiguous
    assert result.scans[0].explained > 0.9
    assert "moved less than" in result.reason


def test_occlusions_and_missing_buildings_do_not_bias_the_pose() -> None:
    """40 % of the directions are occluded, the model lacks one house, and a hedge stands before another."""
    scan = scan_of(STREET, PLACE, step=0.1)
    azimuth = np.degrees(np.arctan2(*(scan.xyz - PLACE)[:, [1, 0]].T)) % 45.0
    seen = scan.xyz[azimuth > 18.0]
    rng = np.random.default_rng(0)
    x, z = rng.uniform(-14, -6, 20_000), rng.uniform(0, 1.5, 20_000)
    hedge = np.column_stack([x, 5.2 + rng.normal(0, 0.01, 20_000), z])
    xyz = np.concatenate([seen, hedge])
    scan = replace(scan, xyz=xyz, origin_index=np.zeros(len(xyz), np.int32))
    given = misplaced(scan, np.array([3.5, -3.5, 0.2]), 15.0)
    (result,) = run([given], model_of((*STREET[:3], *STREET[4:]))).scans
    off, angle = error(result, given)
    assert np.linalg.norm(off[:2]) < 0.01
    assert angle < np.radians(0.06)
    assert 0.5 < result.explained < 0.95


def test_a_correct_scan_stays_in_place() -> None:
    given = misplaced(scan_of(STREET, PLACE), np.zeros(3), 0.0)
    off, angle = error(run([given], model_of(STREET)).scans[0], given)
    assert np.linalg.norm(off[:2]) < 0.005
    assert angle < np.radians(0.05)


def test_a_single_front_does_not_determine_the_shift_along_it() -> None:
    given = misplaced(scan_of(ALONE, PLACE), np.array([0.6, 0.5, 0.0]), 2.0, (1.0, 2.0))
    (result,) = run([given], model_of(ALONE)).scans
    shifts = [d for d in result.directions if d.kind == "shift"]
    along = max(shifts, key=lambda d: abs(d.axis[0]))
    across = max(shifts, key=lambda d: abs(d.axis[1]))
    assert not along.observable
    assert along.sigma == pytest.approx(1.0, rel=0.1)
    assert across.observable
    assert not along.weak, "the prior applies"
    assert across.sigma < 0.01
    assert along in result.unobservable


def test_notes_name_the_undetermined_directions() -> None:
    given = misplaced(scan_of(ALONE, PLACE), np.zeros(3), 0.0, (1.0, 2.0))
    lost, weak = run([given], model_of(ALONE)).notes
    assert "do not determine the shift along [1.0, " in lost or "along [-1.0, " in lost
    assert "is poorly determined" in weak and weak.count("[") == 1


def test_observability_depends_on_the_accuracy_of_the_model() -> None:
    """Without a roof in sight, the ground at the houses' feet tells the height to some centimetres.

    That is little for a model known to a millimetre, and as good as the model for one known to 3 cm.
    """
    given = misplaced(scan_of(STREET, PLACE), np.zeros(3), 0.0, (1.0, 2.0))
    states = []
    for options in (EXACT, RegistrationOptions(sigma_height=0.03), RegistrationOptions(sigma_height=0.5)):
        (result,) = run([given], model_of(STREET), options).scans
        (height,) = (d for d in result.directions if d.kind == "shift" and abs(d.axis[2]) > 0.9)
        assert 0.01 < height.sigma < 0.3, "the data tell it, not the prior of 1 m"
        assert height.weak != height.observable
        states.append(height.observable)
        plan = [d for d in result.directions if d.kind == "shift" and abs(d.axis[2]) < 0.5]
        assert len(plan) == 2 and all(d.observable and not d.weak for d in plan)
    assert states == [False, True, False], "half a metre is more than `observable` allows"


def test_equal_houses_a_pitch_apart_are_ambiguous() -> None:
    row = tuple(BoxHouse(-33 + 11.0 * k, 8, width=8.0) for k in range(7))
    near = replace(misplaced(scan_of(row[2:5], PLACE), np.zeros(3), 0.0, (6.0, 2.0)))
    result = run([near], model_of(row))
    assert result.ambiguous
    assert any(abs(abs(a.shift[0]) - 11.0) < 0.3 for a in result.alternatives)
    (scan,) = result.scans
    sigma = np.sqrt(np.diag(scan.covariance))
    assert 3.0 < sigma[0] < 11.0 and sigma[1] < 0.1  # the pitch is not known, the distance to the wall is
    along = [d for d in scan.directions if d.kind == "shift" and abs(d.axis[0]) > 0.9]
    assert along and not any(d.observable for d in along)
    assert any("nearly as well" in n for n in result.notes)


def test_the_covariance_contains_the_errors_of_the_model() -> None:
    squared = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        shift = np.column_stack([rng.normal(0, 0.05, (len(STREET), 2)), np.zeros(len(STREET))])
        given = misplaced(
            scan_of(STREET, PLACE, seed, step=0.12), np.array([0.3, -0.3, 0.0]), 1.0, (0.4, 0.8)
        )
        (result,) = run([given], model_of(STREET, shift), RegistrationOptions(sigma_height=0.01)).scans
        off = error(result, given)[0][:2]
        C = result.covariance[:2, :2]
        assert np.sqrt(np.diag(C)).max() < 0.05
        squared.append(float(off @ np.linalg.solve(C, off)))
    # 99 % band of a mean of 6 chi-squares of two degrees of freedom
    assert 0.51 < np.mean(squared) < 4.72


def test_wall_offsets_say_where_a_house_really_is() -> None:
    shift = np.zeros((len(STREET), 3))
    shift[1, 1] = 0.12
    given = misplaced(scan_of(STREET, PLACE), np.zeros(3), 0.0, (0.5, 1.0))
    result = run([given], model_of(STREET, shift), RegistrationOptions())
    front = next(w for w in result.walls if w.surface == "B1-0")
    # the model's front is 12 cm too far back, so the house stands before it
    assert front.offset == pytest.approx(0.12, abs=0.04)
    assert front.sigma < 0.05


def test_overlapping_scans_agree() -> None:
    places = [PLACE, np.array([8.0, -1.0, 1.7])]
    shifts = [np.array([2.0, -3.0, 0.3]), np.array([-2.0, 2.0, -0.4])]
    given = [
        misplaced(scan_of(STREET, p, k), s, 8.0 - 14 * k)
        for k, (p, s) in enumerate(zip(places, shifts, strict=True))
    ]
    rng = np.random.default_rng(4)
    shift = np.column_stack([rng.normal(0, 0.05, (len(STREET), 2)), np.zeros(len(STREET))])
    result = run(given, model_of(STREET, shift), RegistrationOptions())
    offs = [error(r, g)[0] for r, g in zip(result.scans, given, strict=True)]
    assert np.linalg.norm((offs[0] - offs[1])[:2]) < 0.01
    assert result.overlap > 100
    assert result.agreement < 0.01


def test_the_same_input_gives_the_same_bytes() -> None:
    given = [
        misplaced(scan_of(STREET, PLACE, k, step=0.15), np.array([0.3, 0.2, 0]), 1.0, (0.4, 0.8))
        for k in (0, 1)
    ]
    one, two = (run(given, model_of(STREET)) for _ in range(2))
    for a, b in zip(one.scans, two.scans, strict=True):
        assert (a.local_from_given.value.matrix == b.local_from_given.value.matrix).all()
        assert (a.covariance == b.covariance).all()


def test_a_distant_model_raises_a_clear_error() -> None:
    given = misplaced(scan_of(ALONE, PLACE, step=0.3), np.zeros(3), 0.0)
    for away, words in ((5000, r"5\.0 km"), (200, r"\d+ m")):
        far = model_of(tuple(replace(b, x=b.x + away) for b in ALONE))
        with pytest.raises(CrsError, match=rf"lies {words} from the scans; check its coordinate system"):
            run([given], far)


def test_a_model_in_another_crs_raises_a_clear_error() -> None:
    given = misplaced(scan_of(ALONE, PLACE, step=0.3), np.zeros(3), 0.0)
    model = replace(model_of(ALONE), world=WorldRef(WORLD.origin, "EPSG:25833"))
    with pytest.raises(CrsError, match="EPSG:25833"):
        run([given], model)


def test_an_empty_model_raises_a_clear_error() -> None:
    given = misplaced(scan_of(ALONE, PLACE, step=0.3), np.zeros(3), 0.0)
    with pytest.raises(InputError, match="has no walls"):
        run([given], CityModel((), WORLD))


def test_every_scan_needs_a_prior() -> None:
    given = misplaced(scan_of(ALONE, PLACE, step=0.3), np.zeros(3), 0.0)
    with pytest.raises(InputError, match="1 scans with 0 pose priors"):
        register([given.scan], model_of(ALONE), [])


def test_prior_comes_with_the_scan() -> None:
    given = misplaced(scan_of(ALONE, PLACE, step=0.3), np.zeros(3), 0.0)
    pose = replace(given.true, to="local", frm="scanner")
    sigma = np.array([2.0, 2.0, 1.0, 0.002, 0.002, 0.1])
    prior = prior_of(replace(given.scan, local_from_scanner=Estimate(pose, np.diag(sigma**2), 0.0)))
    assert prior.sigma == pytest.approx(sigma)
    with pytest.raises(InputError, match="no approximate pose"):
        prior_of(given.scan)


def test_a_prior_rejects_invalid_sigmas() -> None:
    with pytest.raises(ValueError, match="sigmas above zero"):
        PosePrior(np.zeros(3), np.zeros(3), 0.1, 0.1)
