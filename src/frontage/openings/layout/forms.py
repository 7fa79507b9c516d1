"""Openings of one form: what builders meant to be equal, also where the scan shows them only in part."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.layout.groups import (
    HEIGHT,
    LIKE,
    WIDTH,
    equally_high,
    levels_of,
    predicted,
    rows_of,
    size_like,
    values_of,
)

BUILT = 0.012
"""m by which the openings of a building may deviate from their sizes (DIN 18202, up to 3 m)."""
VAGUE = 0.1
"""Share of the size of an opening: borders known no better tell others nothing."""
_ROW = 0.5  # share of the height of a row that an opening of it shows at least


@dataclass(frozen=True, eq=False)
class Completed:
    """An opening known in part, as the others of its form have it.

    number      of the outline
    place       box m
    covariance  (5, 5) m2 of left, right, bottom, top and rise
    form        number of the form
    share       of the openings with such known sizes that are of this form
    """

    number: int
    place: Box
    covariance: Float
    form: int
    share: float


def is_known(outline: Outline) -> Bool:
    """Returns whether the left, right, lower and upper border (4,) of an outline are known to a tenth."""
    x0, z0, x1, z1 = outline.place
    size = np.array([x1 - x0, x1 - x0, z1 - z0, z1 - z0])
    return np.asarray(np.diag(outline.covariance)[:4] < (VAGUE * size) ** 2)


def is_placed(outline: Outline) -> bool:
    """Returns whether both sides of an outline are known, and its sill or its lintel: its row and column."""
    left, right, bottom, top = is_known(outline)
    return bool(left and right and (bottom or top))


class Forms:
    """The forms of the openings of a wall, and their members, the best known first.

    An opening, the best known ones first, joins the form that its sizes fit best if they agree within their
    errors. If none does, a well-known one begins a form. What has two well-known members is a form.
    """

    def __init__(self, outlines: Sequence[Outline]) -> None:
        self._outlines = outlines
        self._own, self._variance = values_of(outlines)
        self._border = np.sqrt([np.diag(v) for v in self._variance]).reshape(-1, 4)
        self._size = self._own @ np.stack([WIDTH, HEIGHT], 1)
        self._sigma = np.sqrt([[s @ v @ s for s in (WIDTH, HEIGHT)] for v in self._variance]).reshape(-1, 2)
        known = np.array([is_known(o) for o in outlines]).reshape(-1, 4)
        self._told: Bool = np.stack([known[:, :2].all(1), known[:, 2:].all(1)], 1)
        self._known: Bool = np.asarray(self._told.all(1))
        groups: list[list[int]] = []
        for k in sorted(range(len(outlines)), key=lambda k: (float((self._sigma / self._size)[k].max()), k)):
            off = [self._off(k, g[0]) for g in groups]
            if off and min(off) < LIKE:
                groups[int(np.argmin(off))].append(k)
            elif self._known[k]:
                groups.append([k])
        self.groups = [tuple(g) for g in groups if self._known[g].sum() > 1]
        self._sizes: dict[tuple[int, tuple[int, ...]], tuple[float, float]] = {}

    def _off(self, k: int, first: int) -> float:
        """Returns by how many sigmas an opening differs in size from the first member of a form."""
        if self._outlines[k].shape != self._outlines[first].shape:
            return np.inf
        error = np.hypot(np.hypot(self._sigma[k], self._sigma[first]), BUILT)
        return float((np.abs(self._size[k] - self._size[first]) / error).max())

    def completed(self) -> list[Completed]:
        """Returns the openings known in part as the forms that they may have make them.

        An opening beside a row of such a form belongs to the row. Otherwise its known borders and the size of
        the form tell the others.
        """
        found = []
        for k in np.flatnonzero(~self._known).tolist():
            fits = [n for n, group in enumerate(self.groups) if self._off(k, group[0]) < LIKE]
            in_rows = [one for form in fits for one in self._in_rows(k, form)]
            found += in_rows or [self._alone(k, form) for form in fits if self._told[k].any()]
        return found

    @cached_property
    def _rows(self) -> list[list[tuple[float, float]]]:
        """For every form, the sills (z, m) of the rows that it may stand in, with their sigmas (m).

        These rows are made of all openings that are as high as the form and whose places are known. At least
        one opening of each row shows both its sill and its lintel, which proves the height of the row.
        """
        high = equally_high(self._outlines, self.groups)
        level, sigma = levels_of(self._own, self._variance, high)
        placed = [[j for j in group if is_placed(self._outlines[j])] for group in high]
        rows = [
            [row for row in rows_of(level, [group], least=1) if self._told[list(row), 1].any()]
            for group in placed
        ]
        told = [[predicted(level, sigma, row, BUILT) for row in own] for own in rows]
        return [next(t for t, group in zip(told, high, strict=True) if g[0] in group) for g in self.groups]

    def _in_rows(self, k: int, form: int) -> list[Completed]:
        """Returns what the rows of a form beside an opening make of it."""
        others = [j for j in self.groups[form] if j != k]
        x, found = self._across(k, others), []
        high, error = self._predicted(others, 1)
        for sill, own in self._rows[form]:
            both = np.minimum(self._own[:, 3], sill + high) - np.maximum(self._own[:, 2], sill)
            beside = both >= _ROW * high
            if beside[k]:
                z = np.array([sill, sill + high]), own**2 + np.diag([0.0, error**2])
                found.append(self._completed(k, form, x, z, beside))
        return found

    def _alone(self, k: int, form: int) -> Completed:
        """Returns what the size of a form makes of an opening."""
        others = [j for j in self.groups[form] if j != k]
        z = _side_by_side(self._own[k, 2:], self._border[k, 2:], *self._predicted(others, 1))
        return self._completed(k, form, self._across(k, others), z, np.ones(len(self._outlines), np.bool_))

    def _across(self, k: int, others: Sequence[int]) -> tuple[Float, Float]:
        """Returns the left and right border (2,) m of an opening like the others, and their covariance."""
        return _side_by_side(self._own[k, :2], self._border[k, :2], *self._predicted(others, 0))

    def _predicted(self, others: Sequence[int], axis: int) -> tuple[float, float]:
        """Returns the width (`axis` 0) or height (1) m of one more opening like the others, and its sigma."""
        key = axis, tuple(others)
        if key not in self._sizes:
            self._sizes[key] = size_like(self._size[:, axis], self._sigma[:, axis], others)
        return self._sizes[key]

    def _completed(
        self, k: int, form: int, x: tuple[Float, Float], z: tuple[Float, Float], beside: Bool
    ) -> Completed:
        """Returns an opening by its borders along x and z with their covariances (2, 2) m2."""
        covariance = np.zeros((5, 5))
        covariance[:2, :2], covariance[2:4, 2:4] = x[1], z[1]
        covariance[4, 4] = self._outlines[k].covariance[4, 4]
        error = np.hypot(np.hypot(self._sigma, self._sigma[k]), BUILT)
        alike = np.all((np.abs(self._size - self._size[k]) < LIKE * error) | ~self._told[k], axis=1) & beside
        named = [j for j in np.flatnonzero(alike).tolist() if j != k]
        right = sum(j in self.groups[form] for j in named)
        place = (float(x[0][0]), float(z[0][0]), float(x[0][1]), float(z[0][1]))
        return Completed(k, place, covariance, form, (right + 0.5) / (len(named) + 1.0))


def _side_by_side(at: Float, sigma: Float, size: float, error: float) -> tuple[Float, Float]:
    """Returns two borders (2,) m that lie `size` m apart, and their covariance (2, 2) m2."""
    weight = np.diag(1.0 / sigma**2) + np.array([[1.0, -1.0], [-1.0, 1.0]]) / error**2
    covariance = np.linalg.inv(weight)
    middle = covariance @ (at / sigma**2 + size / error**2 * np.array([-1.0, 1.0]))
    return np.asarray(middle), np.asarray(covariance)
