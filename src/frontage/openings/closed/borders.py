"""Measures the borders and the depth of an opening that is closed level with the wall."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from frontage.geometry.arrays import Bool, Float
from frontage.model.estimate import Estimate
from frontage.model.masonry import TOLERANCES
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box, grown
from frontage.openings.closed.channels import ChannelLayer, WallSamples, within
from frontage.openings.closed.places import SIZE, CandidatePlaces
from frontage.openings.closed.steps import HEAD, OpeningForm

_ALIKE = 0.4  # share of the step by which the thirds of the inside may differ from the whole
_SHARP = 0.6  # share of the step that must happen within the nearest points
_SOME = 0.3  # share of the step that a border which is not sharp must still show
_NEAR = 0.04  # m beside a border, or two spacings, within which its nearest points lie
_ENDS = 0.05  # share of a side that is left out at either end
_FINE = 0.001  # m between the places of a border that are tried
_SEARCH = 0.12  # m from where it is expected within which a border is looked for
_BEST = 0.002  # m, one sigma of a border at least: gaps between leaf and wall
_BEFORE = 0.08  # m: objects further before the wall are fitted to it
_FEW = 30  # points inside, and on each side of a border
_SLANT = 0.5  # share of its depth that the wall's edge hides of a leaf, or shows of a reveal
_AROUND = (0.5, 0.2)  # m beside the opening, outer and inner end of its wall, without surrounds
_USUAL = 0.997  # share of the openings that lie no further from where they are expected: three sigmas


@dataclass(frozen=True, eq=False)
class Contrast:
    """The sum of a layer's channels that shows an opening from the wall best: one more inside than outside.

    weights  (c,) of the channels
    own      (4,) its steps inwards
    wall     (4,) one sigma of the wall's own steps
    """

    layer: ChannelLayer
    weights: Float
    own: Float
    wall: Float

    def near(self, place: Box) -> tuple[Float, Float]:
        """Returns the places (n, 2) m and values (n,) in a box."""
        xz, values = self.layer.near(place)
        return xz, values @ self.weights


def measure_closed(
    places: CandidatePlaces, k: int, like: Outline, contrast: Contrast, surface: WallSamples
) -> Outline | None:
    """Returns the measured outline of what stands at place number k; None if it is no opening.

    Left, right and one of bottom and top must be sharp. The other (a sill) need not be: it stays where the
    row or the height expects it. The inside must be even, and level with the wall.
    """
    box, form = places.box(k), places.form
    place, covariance = list(box), places.covariance.copy()
    around = contrast.near(grown(box, 2.0 * _SEARCH))
    sharp = np.zeros(4, np.bool_)
    for side in range(4):
        row = (0, 2, 1, 3)[side]
        expected = float(np.sqrt(covariance[row, row]))
        border = _border(contrast, around, box, form, side=side, expected=expected)
        if border is not None:
            sharp[side] = True
            place[side] += border[0]
            covariance[row, :] = covariance[:, row] = 0.0
            covariance[row, row] = border[1] ** 2
        elif contrast.own[side] < _SOME and not (places.node and side == 1):
            return None
    if not _regular(np.subtract(place, box), np.diag(covariance), places.covariance, sharp):
        return None
    for side, other in ((1, 3), (3, 1)):  # the height of the form places the border that is not sharp
        row, known = (2, 3) if side == 1 else (3, 2)
        if sharp[other] and not sharp[side] and covariance[known, known] + SIZE**2 < covariance[row, row]:
            place[side] += place[other] - box[other]
            covariance[row, row] = covariance[known, known] + SIZE**2
    at: Box = (place[0], place[1], place[2], place[3])
    depth = _depth(surface, at, form.rise)
    heads = sharp[1::2].any() if places.node else sharp[3]  # sills hide the foot
    if depth is None or not (sharp[0] and sharp[2] and heads):
        return None
    if depth.value < -_BEFORE or not _even(*around, at, form.rise):
        return None
    covariance[:4, :4] += np.eye(4) * (_SLANT * depth.value) ** 2
    return Outline(like.shape, at, form.rise, covariance, (), depth, 0.0, like.wall)


def _regular(shift: Float, variance: Float, expected: Float, sharp: Bool) -> bool:
    """Returns whether the sharp sides lie as near to where they are expected as those of openings like it do.

    shift  (4,) m, how far off they lie
    """
    rows = np.array([0, 2, 1, 3])[sharp]  # rows of the covariance
    total = expected[np.ix_(rows, rows)] + np.diag(variance[rows])
    return bool(shift[sharp] @ np.linalg.solve(total, shift[sharp]) < stats.chi2.ppf(_USUAL, len(rows)))


def _across(xz: Float, place: Box, side: int, form: OpeningForm) -> tuple[Bool, Float]:
    """Returns which places (n, 2) m lie along a side of a box, and their distance (n,) m across it."""
    x0, z0, x1, z1 = place
    axis = side % 2
    begin, end = (z0, z1 - form.rise) if axis == 0 else (x0, x1)
    margin = (_ENDS if side < 3 else (1.0 - HEAD) / 2.0) * (end - begin)
    along = xz[:, 1 - axis]
    u = xz[:, axis] - place[side]
    if side == 3:
        u = u - form.drop(xz[:, 0] - (x0 + x1) / 2.0)
    return (along > begin + margin) & (along < end - margin) & (np.abs(u) < 2.0 * _SEARCH), u


def _border(
    contrast: Contrast,
    around: tuple[Float, Float],
    box: Box,
    form: OpeningForm,
    *,
    side: int,
    expected: float,
) -> tuple[float, float] | None:
    """Returns the shift m of a side of a box from where it is expected, and its sigma, or None.

    `around` are places (n, 2) m and values (n,). Two means on either side: the likelihood over the place of
    the step, its exponent reduced by as much as means on this wall scatter more than its single points
    predict.
    """
    xz, v = around
    some, u = _across(xz, box, side, form)
    search = float(np.clip(3.0 * expected, _SEARCH / 3.0, _SEARCH))
    order = np.flatnonzero(some)[np.argsort(u[some], kind="stable")]
    u, v = u[order], v[order]
    e = np.arange(-search, search, _FINE)
    cut = np.searchsorted(u, e)
    if len(u) == 0 or min(cut[0], len(u) - cut[-1]) < _FEW // 3:
        return None
    total = np.append(0.0, v.cumsum())
    rest = float(v @ v) - total[cut] ** 2 / cut - (total[-1] - total[cut]) ** 2 / (len(u) - cut)
    best = max(float(rest.min()) / len(u), 1e-9)
    share = min(1.0, 4.0 * best / len(u) / float(contrast.wall[side]) ** 2)
    log_l = -0.5 * share * (rest - rest.min()) / best - 0.5 * (e / np.hypot(expected, _BEST)) ** 2
    weight = np.exp(log_l - log_l.max())
    weight /= weight.sum()
    mean = float(weight @ e)
    jump = _jump(u, v, mean, max(2.0 * contrast.layer.spacing, _NEAR))
    if jump * (1.0 if side < 2 else -1.0) < _SHARP:
        return None
    return mean, float(np.sqrt(weight @ (e - mean) ** 2 + _BEST**2 + contrast.layer.sharp**2))


def _jump(u: Float, v: Float, at: float, near: float) -> float:
    """Returns the mean of the values v (n,) just behind a place of u (n,) m less that just before it.

    It takes the nearest points, ten at least, for scan columns may leave a gap beside the border.
    """
    least = _FEW // 3
    first, middle, last = np.searchsorted(u, at + np.array([-near, 0.0, near]))
    before, after = v[min(first, max(middle - least, 0)) : middle], v[middle : max(last, middle + least)]
    return float(after.mean() - before.mean())


def _even(xz: Float, v: Float, place: Box, rise: float) -> bool:
    """Returns whether the thirds of the inside, across and up, are alike in the values v (n,)."""
    x0, z0, x1, z1 = place
    inside = within(xz, (x0, z0, x1, z1 - rise))
    column, row = (
        np.clip((3.0 * (xz[inside, k] - low) / (high - low)).astype(np.int64), 0, 2)
        for k, low, high in ((0, x0, x1), (1, z0, z1 - rise))
    )
    number = np.bincount(3 * row + column, minlength=9)
    if number.min() < _FEW // 9 + 1:
        return False
    mean = np.bincount(3 * row + column, v[inside], minlength=9) / number
    return bool(np.abs(mean - np.median(mean)).max() < _ALIKE)


def _depth(surface: WallSamples, place: Box, rise: float) -> Estimate[float] | None:
    """Returns the depth m of what closes the opening behind the wall around it; None for few points."""
    x0, z0, x1, z1 = place
    inside = surface.within((x0 + 0.03, z0 + 0.03, x1 - 0.03, z1 - rise - 0.03))
    far, near = _AROUND
    around = np.setdiff1d(surface.within(grown(place, far)), surface.within(grown(place, near)), True)
    if min(len(inside), len(around)) < _FEW:
        return None
    value, variance = [], 0.0
    for some in (inside, around):
        y = surface.y[some]
        value.append(float(np.median(y)))
        noise = 1.4826 * float(np.median(np.abs(y - value[-1])))
        variance += noise**2 * (TOLERANCES.common_noise**2 + 1.57 / len(y))
    return Estimate(value[0] - value[1], np.array([[variance]]), float(len(inside) - 1))
