"""The reflectance of surfaces from the intensity of their echoes.

The intensity of an echo falls with the range R and with the angle of incidence alpha:
``log I = log albedo + a log R + b log cos(alpha) + c_station``. Lambert's law and the radar equation give
a = -2 and b = 1; instruments deviate, and many correct for the range themselves. The exponents are estimated
from the scan itself: within a piece of surface the albedo is constant on average, so that differences within
pieces tell a, b and the offsets of the stations (the within estimator of panel regression). Where one station
sees everything, range and incidence hardly vary within a piece; the fit is then held by its prior, a = 0 and
b = 0, because a smooth trend does not disturb the matching of local structure.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.solve.robust import irls, mad_sigma

_FLOOR = 1e-3  # of the intensity scale 0..1: below it echoes are noise
_LEAST_COSINE = 0.05  # beyond 87 degrees of incidence the correction would only magnify noise
_PRIOR_SIGMA = 2.0  # of the exponents and of log offsets
_MOST_ROWS = 200_000


@dataclass(frozen=True)
class RadiometricModel:
    """The exponents of range and cosine of incidence, and the log offset of every station."""

    range_exponent: float
    cosine_exponent: float
    station_offset: tuple[float, ...]


def log_tone(intensity: Array) -> Float:
    """Returns the logarithm of intensities (n,) 0..1, limited where echoes are noise."""
    return np.log(np.maximum(np.asarray(intensity, np.float64), _FLOOR))


def fit_radiometry(
    tone: Float, ranges: Float, cosine: Float, station: Int, piece: Int, stations: int, seed: int = 0
) -> RadiometricModel:
    """Fits the model to log intensities.

    tone     (n,) log intensity
    ranges   (n,) m; cosine (n,) 0..1 of the angle of incidence
    station  (n,) number of the station, 0..stations-1
    piece    (n,) number of the piece of surface that the point lies on, -1 = none
    """
    rows = np.flatnonzero((piece >= 0) & (station >= 0) & np.isfinite(tone + ranges + cosine))
    if len(rows) > _MOST_ROWS:
        rows = np.random.default_rng(seed).choice(rows, _MOST_ROWS, replace=False)
    if len(rows) < 100:
        return RadiometricModel(0.0, 0.0, (0.0,) * stations)
    design = _design(ranges[rows], cosine[rows], station[rows], stations)
    _, number = np.unique(piece[rows], return_inverse=True)
    design, observed = _within(design, number), _within(tone[rows][:, None], number)[:, 0]
    # The prior enters as rows of its own, with the weight that the noise of the observations gives it.
    p = design.shape[1]
    prior = np.eye(p) * max(mad_sigma(observed), 1e-6) / _PRIOR_SIGMA
    design, observed = np.vstack([design, prior]), np.concatenate([observed, np.zeros(p)])
    fit = irls(
        design,
        observed,
        np.ones(len(observed)),
        sigma_floor=1e-4,
        start=np.zeros(p),
        sigma_start=max(mad_sigma(observed), 1e-4),
    )
    a, b, *offsets = fit.parameters.tolist()
    return RadiometricModel(a, b, (0.0, *offsets))


def corrected(tone: Float, model: RadiometricModel, ranges: Float, cosine: Float, station: Int) -> Float:
    """Returns log tones (n,) without the effect of range, incidence and station.

    Points of unknown range or station, NaN or -1, keep their tones.
    """
    offset = np.append(model.station_offset, 0.0)[station]
    known = np.isfinite(ranges) & np.isfinite(cosine)
    r = np.where(known, np.maximum(ranges, 0.1), 1.0)
    c = np.where(known, np.maximum(cosine, _LEAST_COSINE), 1.0)
    trend = model.range_exponent * np.log(r) + model.cosine_exponent * np.log(c) + offset
    return np.asarray(tone - trend)


def _design(ranges: Float, cosine: Float, station: Int, stations: int) -> Float:
    """Rows of log range, log cosine and one indicator per station but the first."""
    indicators = (station[:, None] == np.arange(1, stations)).astype(np.float64)
    logs = [np.log(np.maximum(ranges, 0.1)), np.log(np.maximum(cosine, _LEAST_COSINE))]
    return np.column_stack([*logs, indicators])


def _within(values: Float, number: Int) -> Float:
    """Subtracts the mean of its piece from every row (n, k)."""
    count = np.bincount(number)[:, None]
    mean = np.column_stack([np.bincount(number, column) for column in values.T]) / count
    return np.asarray(values - mean[number])
