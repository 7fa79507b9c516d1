"""Brings the photos of a facade to one exposure, white balance and vignetting, from where they overlap.

In linear light a photo shows a surface with its own gain per channel (exposure, white balance) and the loss
of its lens towards the corners. Where two photos show the same cell, the difference of the logarithms is free
of the surface, ``g_i - g_j + v(r_i) - v(r_j)`` with ``v(r) = a r^2 + b r^4`` for every camera (Brown and
Lowe, Automatic panoramic image stitching, IJCV 2007, adjust gains like this). What the photos see differently
(cars, reflections, moved shadows) is an outlier: the adjustment is reweighted (Cauchy).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.ortho.mosaic.pictures import CellPictures, same_camera
from frontage.ortho.views import ViewPlan

_CELLS = 1500  # of a pair of photos that are compared, evenly spread,
_ALL_CELLS = 15_000  # and of all pairs, as long as each has enough
_FEWEST = 50  # cells in common below which two photos tell nothing about each other
_ROUNDS = 12  # of the adjustment at most
_CONVERGED = 1e-4  # of the logarithm of light: a hundredth of a code
_CAUCHY = 2.4  # standard deviations; 95 % as efficient as least squares with normal errors
_FALLOFF = 0.5  # likewise of a and b: a lens loses a third of its light in the corners
_KEPT = 0.001  # one sigma of what another facade has told: it is not to change
_NOISE = 0.02  # smallest standard deviation of a difference of logarithms; 8 bits do not tell more
STOPS = 1.5 * np.log(2.0)
"""One sigma of the gains that photos have before anything was compared."""


@dataclass(frozen=True, eq=False)
class PhotoGains:
    """The logarithms by which photos (k) are brighter than the mosaic.

    gain     (k, 3), of the channels in the middle of the photo
    falloff  (k, 2, 3), factors of r^2 and r^4
    """

    gain: Float
    falloff: Float

    def rows(self, number: int) -> Float:
        """The gain and the factors of r^2 and r^4 of photo `number`, by channel, (3, 3)."""
        return np.asarray(np.vstack([self.gain[number][None], self.falloff[number]]))

    def at(self, number: int, radius: Array) -> Array:
        """The logarithm (h, w, 3) float32 of what photo `number` adds at distances (h, w) from its middle."""
        r2 = (radius * radius).astype(np.float32)
        a, b, gain = (v.astype(np.float32) for v in (*self.falloff[number], self.gain[number]))
        channels = [b[channel] * r2 for channel in range(3)]
        for channel, added in enumerate(channels):
            added += a[channel]
            added *= r2
            added += gain[channel]
        return np.asarray(cv2.merge(channels))


def even_light(pictures: CellPictures, gains: PhotoGains) -> Array:
    """The log light (k, h, w, 3) float32 of photos, less what they add to that of the mosaic."""
    even = np.empty_like(pictures.log_light)
    for k, light in enumerate(pictures.log_light):
        np.subtract(light, gains.at(k, pictures.radius[k]), out=even[k])
    return even


def balance_photos(plan: ViewPlan, pictures: CellPictures, known: Mapping[str, Array]) -> PhotoGains:
    """Adjusts gains and vignetting of the photos of a plan.

    `known` holds the rows (3, 3) of `PhotoGains.rows` of photos that other facades have told already: they
    stay as they are, so that facades that share photos have one look. Without any, the mean gain is zero in
    every channel.
    """
    k, names = len(plan.photos), [photo.id for photo in plan.photos]
    camera = same_camera(plan.photos)
    design, values = _differences(plan.clear & pictures.exposed, pictures, camera)
    prior = np.zeros((k + 2 * (camera.max() + 1), 3))
    sigma = np.concatenate([np.full(k, STOPS), np.full(len(prior) - k, _FALLOFF)])
    for number, name in enumerate(names):
        if name in known:
            unknowns = [number, k + 2 * camera[number], k + 2 * camera[number] + 1]
            prior[unknowns], sigma[unknowns] = known[name], _KEPT
    found = np.column_stack([robust_adjustment(design, values[:, c], prior[:, c], sigma) for c in range(3)])
    if known.keys().isdisjoint(names):
        found[:k] -= found[:k].mean(0)
    return PhotoGains(found[:k], found[k:].reshape(-1, 2, 3)[camera])


def _differences(usable: Bool, pictures: CellPictures, camera: Array) -> tuple[Float, Float]:
    """The rows (n, unknowns) of the design and the differences of log light (n, 3) of all pairs of photos."""
    k = len(usable)
    rows, values = [np.zeros((0, k + 2 * (camera.max() + 1)))], [np.zeros((0, 3))]
    pairs = list(combinations(range(k), 2))
    most = max(_FEWEST, min(_CELLS, _ALL_CELLS // max(len(pairs), 1)))
    for i, j in pairs:
        cells = np.flatnonzero(usable[i] & usable[j])
        if len(cells) < _FEWEST:
            continue
        cells = cells[np.linspace(0, len(cells) - 1, min(len(cells), most)).astype(int)]
        row = np.zeros((len(cells), rows[0].shape[1]))
        row[:, i], row[:, j] = 1.0, -1.0
        for photo, sign in ((i, 1.0), (j, -1.0)):
            r2 = pictures.radius[photo].ravel()[cells].astype(np.float64) ** 2
            row[:, k + 2 * camera[photo]] += sign * r2
            row[:, k + 2 * camera[photo] + 1] += sign * r2**2
        rows.append(row)
        light = pictures.log_light.reshape(k, -1, 3)
        values.append((light[i, cells] - light[j, cells]).astype(np.float64))
    return np.concatenate(rows), np.concatenate(values)


def robust_adjustment(design: Float, value: Float, prior: Float, sigma: Float) -> Float:
    """Robust least squares with prior values of the unknowns, of standard deviation `sigma`."""
    found: Float = prior.copy()
    for _ in range(_ROUNDS):
        residual = value - design @ found
        scale = max(1.4826 * float(np.median(np.abs(residual))), _NOISE) if len(value) else _NOISE
        weight = 1.0 / (1.0 + (residual / (_CAUCHY * scale)) ** 2)
        normal = design.T @ (design * weight[:, None]) / scale**2 + np.diag(sigma**-2.0)
        right = design.T @ (weight * value) / scale**2 + prior * sigma**-2.0
        before, found = found, np.asarray(np.linalg.solve(normal, right), np.float64)
        if np.abs(found - before).max(initial=0.0) < _CONVERGED:
            break
    return found
