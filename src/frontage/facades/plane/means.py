"""The last step of a wall's fit: least squares on the mean offsets of its cells, with covariance."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model.scan import Scan
from frontage.solve.correlation import fit_covariance, residual_correlation

_MOST_CELLS = 40_000  # cells of the residual raster; coarser cells lose nothing, as roughness is correlated
_LEAST_WEIGHT = 0.3  # weight of a cell, in good points; less than a third of one says nothing
_LEAST_DOF = 3.0  # degrees of freedom that a variance of correlated residuals has at least
_MOST_STATIONS = 64  # sensor positions on one wall; more of them are a trajectory


@dataclass(frozen=True, eq=False)
class CellMeans:
    """Weighted mean residuals of a wall on a raster.

    mean   (h, w) m, mean residual of each cell
    total  (h, w) sum of the points' weights
    known  (h, w) cells that count
    x, z   (w,), (h,) m, centres of the cells
    flat   (n,) int64, cell of every point
    cell   m, side of a cell
    """

    mean: Float
    total: Float
    known: Bool
    x: Float
    z: Float
    flat: Int
    cell: float

    @property
    def design(self) -> Float:
        """Rows (h, w, 3) of the design matrix: 1, x, z."""
        design = np.ones((*self.known.shape, 3))
        design[..., 1] = self.x
        design[..., 2] = self.z[:, None]
        return design

    def fit(self) -> Float:
        """Fits the plane (c, a, b) to the cell means by least squares; all cells weigh the same."""
        a = self.design[self.known]
        return np.asarray(np.linalg.lstsq(a.T @ a, a.T @ self.mean[self.known], rcond=None)[0], np.float64)

    def centred(self, step: Float, x: float, z: float) -> "CellMeans":
        """Subtracts the plane `step` (3,) from the means, and counts x and z from the point (x, z) m."""
        return replace(self, mean=self.mean - self.design @ step, x=self.x - x, z=self.z - z)

    def covariance(self) -> tuple[Float, float]:
        """Returns the covariance (3, 3) of (c, a, b) and the effective degrees of freedom."""
        design = self.design
        correlation = residual_correlation(self.mean, self.known, self.cell)
        covariance = fit_covariance(design, self.known, correlation)
        # the fit has absorbed some variance of the residuals; its mean over the wall is added back
        rows = design[self.known]
        spread = rows.T @ rows / len(rows)
        for _ in range(3):
            raised = correlation.raised(float(np.sum(covariance * spread)))
            covariance = fit_covariance(design, self.known, raised)
        effective = float(correlation.covariance[0] / max(covariance[0, 0], 1e-300))
        # few independent values know their variance poorly, so errors follow Student's distribution
        dof = max(effective - 3.0, _LEAST_DOF)
        return covariance * dof / (dof - 2.0), max(effective - 3.0, 1.0)


def cell_means(x: Float, z: Float, r: Float, weights: Float, cell: float) -> CellMeans:
    """Averages residuals r (n,) m with `weights` (n,) in cells of `cell` m of the wall at (x, z) (n,) m."""
    x0, z0 = float(x.min()), float(z.min())
    wide, high = float(np.ptp(x)), float(np.ptp(z))
    while (wide / cell + 1) * (high / cell + 1) > _MOST_CELLS:
        cell *= 1.5
    column = ((x - x0) * (1.0 / cell)).astype(np.int64)
    row = ((z - z0) * (1.0 / cell)).astype(np.int64)
    h, w = int(row.max()) + 1, int(column.max()) + 1
    flat = row * w + column
    total = np.bincount(flat, weights, minlength=h * w).astype(np.float64).reshape(h, w)
    mean: Float = np.bincount(flat, weights * r, minlength=h * w).reshape(h, w) / np.maximum(total, 1e-12)
    return CellMeans(
        mean,
        total,
        _inner(total > _LEAST_WEIGHT),
        np.asarray(x0 + (np.arange(w) + 0.5) * cell, np.float64),
        np.asarray(z0 + (np.arange(h) + 0.5) * cell, np.float64),
        flat,
        cell,
    )


def _inner(known: Bool) -> Bool:
    """Returns the cells (h, w) with wall all around them, if at least half of the cells are such.

    At the border of a wall and of its openings, a cell also holds points of something else (ground, a reveal,
    the next wall), and always on the same side of the plane.
    """
    inner = ndimage.binary_erosion(known, np.ones((3, 3), np.bool_))
    return np.asarray(inner if 2 * np.count_nonzero(inner) > np.count_nonzero(known) else known, np.bool_)


def measuring_station(scan: Scan, index: Int) -> Int:
    """Returns which station, or which pass of a vehicle, measured each of the points `index` (n,): 0, 1, ...

    A trajectory is a chain of many near positions; a jump in it starts another pass. -1 is unknown.
    """
    origin = scan.origin_index[index].astype(np.int64)
    if len(scan.origins) == 0 or not (origin >= 0).any():
        return np.full(len(index), -1, np.int64)
    used = np.flatnonzero(np.bincount(origin[origin >= 0], minlength=len(scan.origins)))
    number = np.full(len(scan.origins) + 1, -1, np.int64)
    if len(used) <= _MOST_STATIONS:
        number[used] = np.arange(len(used))
    else:
        jump = np.linalg.norm(np.diff(scan.origins[used], axis=0), axis=1)
        number[used] = np.concatenate([[0], np.cumsum(jump > max(10.0 * float(np.median(jump)), 2.0))])
    return np.asarray(number[origin], np.int64)


def station_covariance(means: CellMeans, station: Int, weights: Float, r: Float, white: Float) -> Float:
    """Estimates the covariance (3, 3) that stations add when each is off by an error of its own.

    station  (n,) result of `measuring_station`
    weights  (n,) weights of the points; `r` (n,) m, their residuals
    white    (3, 3) covariance without this error

    The scatter of the stations' mean residuals, less what `white` explains of it, is a variance component.
    Each station's share of every cell carries it through the fit. Fewer than two stations give zeros, because
    an error that they have in common (registration, range) does not show in one cloud.
    """
    number = int(station.max()) + 1
    known = (station >= 0) & means.known.ravel()[means.flat]
    share: Array = (
        np.bincount(station[known], weights[known], minlength=number) if number > 1 else np.zeros(1)
    )
    if (share > 0.02 * share.sum()).sum() < 2:
        return np.zeros((3, 3))
    part = np.where(known, weights / np.maximum(means.total.ravel()[means.flat], 1e-12), 0.0)
    row, column = np.divmod(means.flat, means.known.shape[1])
    label = np.where(station >= 0, station, 0)
    pull = np.column_stack(
        [np.bincount(label, part * a, number) for a in (1.0, means.x[column], means.z[row])]
    )
    area = pull[:, 0]
    offset: Array = np.bincount(label, part * r, number) / np.maximum(area, 1e-12)
    weight = area / area.sum()
    stations = 1.0 / float((weight**2).sum())  # effective number
    scatter = float((weight * (offset - weight @ offset) ** 2).sum()) * stations / max(stations - 1.0, 0.5)
    variance = max(scatter - float(white[0, 0]) * stations, 0.0)
    design = means.design[means.known]
    gain = pull @ np.linalg.pinv(design.T @ design)
    return np.asarray(variance * gain.T @ gain, np.float64)
