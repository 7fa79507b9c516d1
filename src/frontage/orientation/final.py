"""The final adjustment: control measured at improving poses, everything adjusted, every photo judged."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Photo
from frontage.orientation.abreast import each
from frontage.orientation.adjustment import Adjustment, Dependence, Network, NotDetermined, adjust
from frontage.orientation.control import ControlPoints, find_control
from frontage.orientation.network import CONTROL, SURFACES, TIES, TiePoints, build_network
from frontage.orientation.options import OrientationOptions
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.result import Orientation, OrientedPhoto, Unoriented
from frontage.orientation.verify import Verdict, verify

Tell = Callable[[str], None]

_CLUSTER_M = 2.0  # wider than a template and than the errors of neighbouring key points are alike
_SHARED = 0.025  # of the spacing of the scan: how well the middle of its samples tells where an edge is
_REACH_M = 5.0  # over which that error changes, about two bays and two storeys
_PASSES = ((12, 24), (6, 12))  # radius of the search for control and distance of templates, px of renderings
_FEWEST_CONTROL = 12
_FEWEST_TIES = 30
_CHECKED = 0.2  # of the control points that are left out for a check
_NAMES = {TIES: "tie points", CONTROL: "control", SURFACES: "surfaces"}


@dataclass(frozen=True, eq=False)
class _State:
    """The photos that are still in, with what was measured in them, and the last adjustment."""

    numbers: Int
    photos: tuple[Photo, ...]
    ties: TiePoints
    control: tuple[ControlPoints, ...]
    network: Network
    adjustment: Adjustment


def adjusted_orientation(
    given: Sequence[Photo],
    numbers: Int,
    photos: Sequence[Photo],
    ties: TiePoints,
    surface: ScannedSurface,
    image_of: ImageOf,
    unoriented: Sequence[Unoriented],
    *,
    options: OrientationOptions,
    camera_sigmas: Sequence[Float],
    seed: int,
    tell: Tell,
) -> Orientation:
    """Adjusts placed photos and judges each; those that the scan contradicts are taken out."""
    left = list(unoriented)
    state: _State | None = None
    verdicts: list[Verdict] = []
    for search in _PASSES:
        if not len(photos):
            break
        state = _adjusted(numbers, photos, ties, surface, image_of, camera_sigmas, search=search, tell=tell)
        photos = _with_poses(state)
        ties = replace(state.ties, xyz=state.adjustment.points[: len(state.ties.xyz)])
        verdicts = []
        for verdict in each(lambda photo: verify(photo, surface, image_of), photos):
            tell("checking")
            verdicts.append(verdict)
        keep, refused = _judged(state, photos, verdicts)
        left += refused
        numbers, photos, ties = numbers[keep], tuple(photos[k] for k in keep), _of_photos(ties, keep)
        verdicts = [verdicts[k] for k in keep]
        if refused and search == _PASSES[-1] and len(photos):
            state = _adjusted(
                numbers, photos, ties, surface, image_of, camera_sigmas, search=search, tell=tell
            )
            photos = _with_poses(state)
    if state is None or not len(photos):
        return _nothing(surface, left)
    checks = _check(state, surface, camera_sigmas, seed)
    oriented = tuple(
        _oriented(k, state, photo, verdict, checks[k])
        for k, (photo, verdict) in enumerate(zip(photos, verdicts, strict=True))
    )
    return _orientation(oriented, left, state, surface)


def _adjusted(
    numbers: Int,
    photos: Sequence[Photo],
    ties: TiePoints,
    surface: ScannedSurface,
    image_of: ImageOf,
    camera_sigmas: Sequence[Float],
    *,
    search: tuple[int, int],
    tell: Tell,
) -> _State:
    """Measures control at the present poses and adjusts; photos that nothing determines are left out."""
    control = []
    radius, step = search

    def measure(photo: Photo) -> ControlPoints:
        return find_control(photo, surface, image_of, radius=radius, step=step)

    for found in each(measure, photos):
        tell("control")
        control.append(found)
    sigmas = [camera_sigmas[k] for k in numbers] if len(camera_sigmas) else []
    network = build_network(photos, ties, control, surface, camera_sigmas=sigmas)
    tell("adjusting")
    try:
        adjustment = adjust(network, dependence=dependence_of(network, len(ties.xyz), surface))
    except NotDetermined as error:
        keep = np.setdiff1d(np.arange(len(photos)), np.array(error.bodies, np.int64))
        if len(keep) == len(photos) or not len(keep):
            raise
        some = [photos[k] for k in keep]
        return _adjusted(
            numbers[keep],
            some,
            _of_photos(ties, keep),
            surface,
            image_of,
            camera_sigmas,
            search=search,
            tell=tell,
        )
    return _State(numbers, tuple(photos), ties, tuple(control), network, adjustment)


def dependence_of(network: Network, ties: int, surface: ScannedSurface) -> Dependence:
    """Which errors of a network are alike; its first `ties` points are tie points, the others control."""
    cube = np.floor(network.points / _CLUSTER_M).astype(np.int64)
    cluster = np.unique(cube, axis=0, return_inverse=True)[1].ravel()
    shared = np.zeros(len(network.points))
    shared[ties:] = _SHARED * float(np.median(surface.spacing))
    return Dependence(np.asarray(cluster, np.int64), shared, _REACH_M)


def _with_poses(state: _State) -> tuple[Photo, ...]:
    """The photos with adjusted poses and cameras."""
    found = state.adjustment
    cameras = [found.cameras[k].value for k in found.photos.camera]
    return tuple(
        replace(photo, camera=cameras[k], local_from_camera=found.photo_pose(k))
        for k, photo in enumerate(state.photos)
    )


def _of_photos(ties: TiePoints, keep: Int) -> TiePoints:
    """The tie points of some photos, which are numbered anew."""
    place = np.full(max(int(ties.photo.max(initial=-1)), int(keep.max(initial=-1))) + 1, -1)
    place[keep] = np.arange(len(keep))
    rows = place[ties.photo] >= 0
    return TiePoints(ties.xyz, place[ties.photo[rows]], ties.point[rows], ties.pixels[rows])


def _judged(
    state: _State, photos: Sequence[Photo], verdicts: Sequence[Verdict]
) -> tuple[Int, list[Unoriented]]:
    """Which photos may stay, and why the others may not."""
    keep, refused = [], list[Unoriented]()
    for k, (photo, verdict) in enumerate(zip(photos, verdicts, strict=True)):
        control, ties = _count(state, k, CONTROL), _count(state, k, TIES)
        if verdict.contradicted:
            text = f"the scan is found {verdict.shift:.0f} px from where its pose puts it"
            refused.append(Unoriented(photo.id, "O104", text))
        elif control < _FEWEST_CONTROL and ties < _FEWEST_TIES:
            text = f"only {control} control points and {ties} tie points support its pose"
            refused.append(Unoriented(photo.id, "O105", text))
        else:
            keep.append(k)
    return np.array(keep, np.int64), refused


def _rows(state: _State, photo: int, group: int) -> Int:
    images = state.network.images
    used = state.adjustment.used & (images.photo == photo) & (images.group == group)
    return np.flatnonzero(used)


def _count(state: _State, photo: int, group: int) -> int:
    return len(_rows(state, photo, group))


def _check(state: _State, surface: ScannedSurface, camera_sigmas: Sequence[Float], seed: int) -> Float:
    """Root mean square error (p,) m of control points that another adjustment did not use."""
    rng = np.random.default_rng(seed)
    out = [rng.random(len(c)) < _CHECKED for c in state.control]
    rest = [c.take(~o) for c, o in zip(state.control, out, strict=True)]
    sigmas = [camera_sigmas[k] for k in state.numbers] if len(camera_sigmas) else []
    photos = _with_poses(state)
    ties = replace(state.ties, xyz=state.adjustment.points[: len(state.ties.xyz)])
    network = build_network(photos, ties, rest, surface, camera_sigmas=sigmas)
    try:
        found = adjust(network)
    except NotDetermined:
        return np.full(len(photos), np.nan)
    errors = np.full(len(photos), np.nan)
    for k, (control, mask) in enumerate(zip(state.control, out, strict=True)):
        used = mask & _used_control(state, k)
        if used.sum() >= 3:
            pose = found.photo_pose(k).value
            camera = found.cameras[found.photos.camera[k]].value
            inside = pose.inverse.apply(control.xyz[used])
            off = camera.project(inside) - control.pixels[used]
            metres = off * (inside[:, 2:] / float(camera.params[0]))
            errors[k] = float(np.sqrt(np.nanmean(metres**2)))
    return errors


def _used_control(state: _State, photo: int) -> Bool:
    """Which control points (n,) of a photo the adjustment used."""
    images = state.network.images
    mine = (images.photo == photo) & (images.group == CONTROL)
    used: Bool = state.adjustment.used[mine]
    return used


def _oriented(k: int, state: _State, photo: Photo, verdict: Verdict, check: float) -> OrientedPhoto:
    found = state.adjustment
    control, ties = _rows(state, k, CONTROL), _rows(state, k, TIES)
    return OrientedPhoto(
        photo,
        int(state.numbers[k]),
        len(control),
        _rms(found.residuals[control]),
        len(ties),
        _rms(found.residuals[ties]),
        check,
        float(np.nanmean(found.redundancy[control])) if len(control) else float("nan"),
        float(np.nanmedian(found.detectable_bias[control])) if len(control) else float("nan"),
        "confirmed" if verdict.confirmed else "tied" if len(ties) >= _FEWEST_TIES else "plain",
        verdict.rival,
        found.cameras[found.photos.camera[k]].sigma,
        state.network.images.pixels[control],
        found.residuals[control],
    )


def _rms(residuals: Float) -> float:
    return float(np.sqrt(np.mean(residuals**2))) if residuals.size else float("nan")


def _orientation(
    photos: tuple[OrientedPhoto, ...], left: Sequence[Unoriented], state: _State, surface: ScannedSurface
) -> Orientation:
    found, images = state.adjustment, state.network.images
    n = len(state.ties.xyz)
    rows = np.flatnonzero(found.used & (images.group == TIES))
    rays = np.bincount(images.point[rows], minlength=n)
    good = np.flatnonzero(found.determined[:n] & (rays >= 2))
    place = np.full(n, -1)
    place[good] = np.arange(len(good))
    rows = rows[place[images.point[rows]] >= 0]
    factors = np.sqrt(found.factors)
    return Orientation(
        photos,
        tuple(left),
        surface.kind,
        found.points[good],
        found.sigma_points[good],
        place[images.point[rows]],
        images.photo[rows],
        images.pixels[rows],
        {name: float(factors[g]) for g, name in _NAMES.items() if g < len(factors)},
        found.sigma0,
        found.dof,
        int(found.rejected.sum()),
    )


def _nothing(surface: ScannedSurface, left: Sequence[Unoriented]) -> Orientation:
    none, rows = np.empty((0, 3)), np.empty(0, np.int64)
    return Orientation(
        (), tuple(left), surface.kind, none, none, rows, rows, np.empty((0, 2)), {}, float("nan"), 0, 0
    )
