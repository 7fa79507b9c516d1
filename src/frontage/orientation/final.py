"""The final adjustment: control measured at improving poses, everything adjusted, every photo judged."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.model import Photo
from frontage.orientation.adjusted import AdjustedPhotos
from frontage.orientation.adjustment import (
    AdjustmentOptions,
    Dependence,
    Network,
    NotDetermined,
    adjust,
)
from frontage.orientation.control import ControlPoints
from frontage.orientation.dependence import dependence_of
from frontage.orientation.drawings import draw_scan
from frontage.orientation.elsewhere import OtherPlaces
from frontage.orientation.judging import in_one_word, judged
from frontage.orientation.measuring import Search, measured_control
from frontage.orientation.neighbours import placed_again
from frontage.orientation.network import CONTROL, PLACES, SURFACES, build_network, by_confirmation
from frontage.orientation.outvoted import by_control_alone, most_outvoted
from frontage.orientation.placed import Placed, Scene, contrary, prior_of
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.result import Orientation, OrientedPhoto, Unoriented
from frontage.orientation.rigs import adjusted_rigs, rig_notes
from frontage.orientation.significance import CRITICAL
from frontage.orientation.templates import HALF
from frontage.orientation.tying import tied_to_neighbours, without_contradicted
from frontage.orientation.verify import Verdict, verify
from frontage.orientation.views import Views
from frontage.solve.abreast import each

# Of a thousand good observations one fails (Baarda 1968): false matches of templates are rarely far off.
_TESTS = AdjustmentOptions(critical=CRITICAL, known=frozenset({PLACES}))
_AS_STATED = AdjustmentOptions(loss="none", snooping=False, variance_components=False)
# Small templates stand larger errors of the pose, large ones are precise.
_PASSES = (Search(12, 24), Search(6, 12, 2 * HALF))
_FEWEST_CHECKED = 3
_CHECKED = 0.2  # of the control points that are left out for a check


def adjusted_orientation(scene: Scene, placed: Placed, unoriented: Sequence[Unoriented]) -> Orientation:
    """Adjusts placed photos and judges each; those that the scan contradicts are taken out."""
    left = list(unoriented)
    passes = list(_PASSES)
    while passes and len(placed.photos):
        search = passes.pop(0)
        state = _adjusted(scene, placed, search, last=not passes)
        left += _lost(placed, state)
        improved = state.improved
        verdicts = _verdicts(scene, improved.photos)
        if not passes:
            others = OtherPlaces(scene.surface, scene.image_of)
            given = [scene.given[n] for n in improved.numbers]
            verdicts = others.judged(improved.photos, given, verdicts, state.blocks)
        keep, refused = judged(state, verdicts, contrary(improved, scene.given), last=not passes)
        placed = improved.only(keep)
        if passes:
            placed, refused = _improved(scene, placed, refused)
        elif refused:
            passes = [search]  # what the refused photos contributed has to go
        left += refused
    if not len(placed.photos):
        return _nothing(scene.surface, left)
    rows = zip(placed.photos, verdicts, _check(state, scene.seed), strict=True)
    oriented = tuple(_oriented(k, state, *row) for k, row in enumerate(rows))
    drawings = draw_scan(placed.photos, scene.surface)
    rigs = adjusted_rigs(scene.rigs, [p.id for p in placed.photos], state.adjustment)
    found = _orientation(oriented, left, state, scene.surface)
    return replace(found, drawings=drawings, rigs=rigs, notes=rig_notes(oriented))


def _improved(scene: Scene, placed: Placed, refused: Sequence[Unoriented]) -> tuple[Placed, list[Unoriented]]:
    """What the poses of the first adjustment and the scan tell of the other photos and of tie points."""
    views = Views(scene, [placed])  # the scan is drawn once for all three
    placed, refused = placed_again(scene, placed, refused, views)
    return without_contradicted(tied_to_neighbours(scene, placed, views), views), refused


def _lost(placed: Placed, state: AdjustedPhotos) -> list[Unoriented]:
    """The photos that the observations do not determine."""
    lost = np.flatnonzero(~np.isin(placed.numbers, state.placed.numbers))
    text = "nothing that was found in it determines its pose"
    return [Unoriented(placed.photos[k].id, "O100", text) for k in lost]


def _verdicts(scene: Scene, photos: Sequence[Photo]) -> list[Verdict]:
    verdicts = []
    for verdict in each(lambda photo: verify(photo, scene.surface, scene.image_of), photos):
        scene.tell("checking")
        verdicts.append(verdict)
    return verdicts


def _adjusted(scene: Scene, placed: Placed, search: Search, *, last: bool) -> AdjustedPhotos:
    """Measures control at the present poses and adjusts; photos that nothing determines are left out.

    Only the `last` adjustment asks which errors are alike: those before give places to look for control at.
    Photos whose control agrees on another pose lose their tie points, the worst of them first.
    """
    control = []

    def measure(photo: Photo) -> ControlPoints:
        return measured_control(photo, scene.surface, scene.image_of, search)

    for found in each(measure, placed.photos):
        scene.tell("control")
        control.append(found)
    while True:
        network = _network(scene, placed, control)
        try:
            dependence = dependence_of(placed.photos, control, scene.surface) if last else None
            state = AdjustedPhotos(placed, tuple(control), network, adjust(network, _TESTS, dependence))
        except NotDetermined as error:
            on = network.photos
            lost = np.isin(on.body, error.bodies) | np.isin(on.mount, error.mounts)
            keep = np.flatnonzero(~lost)
            if len(keep) == len(placed.photos) or not len(keep):
                raise
            placed, control = placed.only(keep), [control[k] for k in keep]
            continue
        outvoted = most_outvoted(state, scene.seed)
        if outvoted is None:
            return _confirmed(state, dependence) if last else state
        placed = by_control_alone(placed, outvoted)


def _confirmed(state: AdjustedPhotos, dependence: Dependence | None) -> AdjustedPhotos:
    """Adjusts once more, with a variance each for tie points by what confirms them.

    Only now, because false ones that are believed less no longer contradict the control of their photo.
    """
    network = by_confirmation(state.network)
    if np.array_equal(network.images.group, state.network.images.group):
        return state
    return replace(state, network=network, adjustment=adjust(network, _TESTS, dependence))


def _network(scene: Scene, placed: Placed, control: Sequence[ControlPoints]) -> Network:
    sigmas = [scene.camera_sigmas[k] for k in placed.numbers] if len(scene.camera_sigmas) else []
    priors = [prior_of(scene.given[k]) for k in placed.numbers]
    return build_network(
        placed.photos,
        placed.ties,
        control,
        scene.surface,
        priors=priors,
        camera_sigmas=sigmas,
        rigs=scene.rigs,
    )


def _check(state: AdjustedPhotos, seed: int) -> Float:
    """Root mean square error (p,) m of control points that another adjustment did not use."""
    rng = np.random.default_rng(seed)
    out = [rng.random(len(c)) < _CHECKED for c in state.control]
    errors = np.full(len(out), np.nan)
    try:
        found = adjust(_without_control(state, np.concatenate(out)), _AS_STATED)
    except NotDetermined:
        return errors
    for k, (control, mask) in enumerate(zip(state.control, out, strict=True)):
        used = mask & state.used_control(k)
        if used.sum() >= _FEWEST_CHECKED:
            camera = found.cameras[found.photos.camera[k]].value
            inside = found.photo_pose(k).value.inverse.apply(control.xyz[used])
            off = camera.project(inside) - control.pixels[used]
            errors[k] = float(np.sqrt(np.nanmean((off * (inside[:, 2:] / camera.params[0])) ** 2)))
    return errors


def _without_control(state: AdjustedPhotos, out: Bool) -> Network:
    """The adjusted network with the observations and variances of its adjustment, but some control (c,)."""
    network, found = state.network, state.adjustment
    used = found.used.copy()
    used[network.images.group == CONTROL] &= ~out
    images, surfaces = network.images.take(used), network.surfaces.take(found.surface_used)
    wider = np.sqrt(found.factors)
    return replace(
        network,
        poses=tuple(pose.value for pose in found.poses),
        points=found.points,
        images=replace(images, sigma=images.sigma * wider[images.group]),
        surfaces=replace(surfaces, sigma=surfaces.sigma * wider[surfaces.group]),
    )


def _oriented(k: int, state: AdjustedPhotos, photo: Photo, verdict: Verdict, check: float) -> OrientedPhoto:
    found = state.adjustment
    control, ties = state.rows(k, CONTROL), state.ties_of(k)
    control = control[np.argsort(state.network.images.sigma[control], kind="stable")]
    return OrientedPhoto(
        photo,
        int(state.placed.numbers[k]),
        len(control),
        _rms(found.residuals[control]),
        len(ties),
        _rms(found.residuals[ties]),
        check,
        float(np.nanmean(found.redundancy[control])) if len(control) else float("nan"),
        float(np.nanmedian(found.detectable_bias[control])) if len(control) else float("nan"),
        in_one_word(state, k, verdict),
        verdict.rival,
        found.cameras[found.photos.camera[k]].sigma,
        state.network.images.pixels[control],
        found.residuals[control],
    )


def _rms(residuals: Float) -> float:
    return float(np.sqrt(np.mean(residuals**2))) if residuals.size else float("nan")


def _orientation(
    photos: tuple[OrientedPhoto, ...],
    left: Sequence[Unoriented],
    state: AdjustedPhotos,
    surface: ScannedSurface,
) -> Orientation:
    found, images = state.adjustment, state.network.images
    n = len(state.placed.ties.xyz)
    rows = np.flatnonzero(state.ties)
    rays = np.bincount(images.point[rows], minlength=n)
    good = np.flatnonzero(found.determined[:n] & (rays >= 2))
    place = np.full(n, -1)
    place[good] = np.arange(len(good))
    rows = rows[place[images.point[rows]] >= 0]
    return Orientation(
        photos,
        tuple(left),
        surface.kind,
        found.points[good],
        found.sigma_points[good],
        place[images.point[rows]],
        images.photo[rows],
        images.pixels[rows],
        _factors(state),
        found.sigma0,
        found.dof,
        int(found.rejected.sum()),
    )


def _factors(state: AdjustedPhotos) -> dict[str, float]:
    """The standard deviations that were found, relative to those stated; of all tie points together."""
    found, group = state.adjustment.factors, state.network.images.group[state.ties]
    factors = {"tie points": float(np.sqrt(found[group].mean()))} if len(group) else {}
    names = {CONTROL: "control", SURFACES: "surfaces"}
    return factors | {name: float(np.sqrt(found[g])) for g, name in names.items() if g < len(found)}


def _nothing(surface: ScannedSurface, left: Sequence[Unoriented]) -> Orientation:
    none, rows = np.empty((0, 3)), np.empty(0, np.int64)
    return Orientation(
        (), tuple(left), surface.kind, none, none, rows, rows, np.empty((0, 2)), {}, float("nan"), 0, 0
    )
