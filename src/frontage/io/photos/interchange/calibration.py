"""The camera that exchange formats have in common, and its equivalents among COLMAP's models.

With normalised coordinates (x, y), x right and y down, and ``q = x^2 + y^2``::

    x_d = x (1 + k1 q + k2 q^2 + k3 q^3 + k4 q^4) + 2 p1 x y + p2 (q + 2 x^2)
    y_d = y (1 + k1 q + k2 q^2 + k3 q^3 + k4 q^4) + 2 p2 x y + p1 (q + 2 y^2)
    u = fx x_d + cx,  v = fy y_d + cy

(x, y) is (X/Z, Y/Z) for a frame camera; for a fisheye it has the same direction and the length of the angle
from the axis. This order of p1 and p2 is OpenCV's and COLMAP's. A sphere is COLMAP's EQUIRECTANGULAR.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float
from frontage.geometry.camera import calibration_matrix
from frontage.geometry.lens import Lens
from frontage.model import Camera

VISIBLE_PX = 0.05
"""A part of a camera that no model of ours has may move no corner of the picture by more than this."""

_SAMPLES = 400  # radii at which a polynomial is compared with its replacement
_ROUNDS = 30  # of the weights by which the replacement is found

Kind = Literal["frame", "fisheye", "sphere"]


@dataclass(frozen=True)
class Calibration:
    """A camera in pixels, as exchange formats describe it (see the module).

    kind           central projection, equidistant fisheye or equirectangular panorama
    width, height  px
    focal          (fx, fy) px
    centre         (cx, cy) px from the outer corner of the first pixel
    radial         k1..k4
    tangential     (p1, p2)
    """

    kind: Kind
    width: int
    height: int
    focal: tuple[float, float]
    centre: tuple[float, float]
    radial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)

    def camera(self) -> tuple[Camera, tuple[str, ...]]:
        """The simplest of COLMAP's models that is this camera, and notes on what had to be approximated.

        Raises ValueError for a focal length that is not positive, and where no model comes within
        `VISIBLE_PX`.
        """
        if self.kind == "sphere":
            return self._sphere(), ()
        if min(self.focal) <= 0:
            raise ValueError(f"a focal length of {min(self.focal):g} px is not positive")
        notes: tuple[str, ...] = ()
        pinhole = [*self.focal, *self.centre]
        (k1, k2, k3, k4), p = self.radial, self.tangential
        if self.kind == "fisheye":
            if any(p):
                model, more = "THIN_PRISM_FISHEYE", [k1, k2, *p, k3, k4, 0.0, 0.0]
            else:
                model, more = "OPENCV_FISHEYE", [k1, k2, k3, k4]
        elif k4:
            numerator, divisor, worst = self._rational()
            model, more = "FULL_OPENCV", [*numerator[:2], *p, numerator[2], *divisor]
            notes = (f"the distortion term k4 was replaced by a quotient that is within {worst:.2g} px",)
        elif k3:
            model, more = "FULL_OPENCV", [k1, k2, *p, k3, 0.0, 0.0, 0.0]
        elif any((k1, k2, *p)):
            model, more = "OPENCV", [k1, k2, *p]
        else:
            model, more = "PINHOLE", []
        return Camera(model, self.width, self.height, np.array([*pinhole, *more])), notes

    def _sphere(self) -> Camera:
        if self.width != 2 * self.height:
            raise ValueError(f"a panorama of {self.width} x {self.height} px is not twice as wide as high")
        return Camera(
            "EQUIRECTANGULAR", self.width, self.height, np.array([self.width, self.height], np.float64)
        )

    def corners(self) -> Float:
        """The normalised, distorted coordinates (4, 2) of the corners of the picture."""
        outer = np.array([[0, 0], [self.width, 0], [0, self.height], [self.width, self.height]], np.float64)
        normalised: Float = (outer - self.centre) / self.focal
        return normalised

    def _rational(self) -> tuple[Float, Float, float]:
        """Three coefficients above and three below a line that replace k1..k4, and the largest error in px.

        COLMAP's models of frame cameras have no term of the eighth order. Raises ValueError where the
        quotient misses the polynomial by more than `VISIBLE_PX` anywhere in the picture.
        """
        lens = Lens(self.radial)
        radius = np.hypot(*lens.undistort(self.corners()).T).max()
        if not np.isfinite(radius):
            raise ValueError("its distortion folds the picture before its corners")
        r = radius * np.sqrt(0.5 - 0.5 * np.cos(np.linspace(0.02, np.pi, _SAMPLES)))  # dense at the ends
        q, f = (r / radius) ** 2, lens.factor(r * r)[0]
        powers, solution = np.column_stack([q, q**2, q**3]), np.zeros(6)
        weight, divisor, worst = r.copy(), np.ones_like(r), np.inf
        for _ in range(_ROUNDS):
            rows = np.hstack([powers, -f[:, None] * powers]) * (weight / divisor)[:, None]
            trial = np.linalg.lstsq(rows, (f - 1) * weight / divisor, rcond=1e-15)[0]
            divisor = 1 + powers @ trial[3:]
            miss = np.abs(r * ((1 + powers @ trial[:3]) / divisor - f)) * max(self.focal)
            if miss.max() < worst:
                worst, solution = float(miss.max()), trial
            if not 0 < miss.max() < np.inf or divisor.min() <= 0:
                break
            weight = weight * np.sqrt(0.05 + miss / miss.max())  # Lawson's: towards the least largest error
        solution = solution / np.tile([radius**2, radius**4, radius**6], 2)
        numerator, below = solution[:3], solution[3:]
        if not worst <= VISIBLE_PX or Lens(tuple(numerator), tuple(below)).limit < radius:
            raise ValueError(f"its distortion term k4 can only be approximated to {worst:.2g} px")
        return numerator, below, worst


def of_camera(camera: Camera, format_name: str) -> Calibration:
    """The same camera as a `Calibration`.

    Raises InputError (I114) for a camera that has none: FOV, division, prism and rational distortion.
    """
    if camera.model == "EQUIRECTANGULAR":
        if tuple(camera.params) != (camera.width, camera.height) or camera.width != 2 * camera.height:
            raise refused(camera, format_name, "is no panorama of the whole sphere")
        w, h = camera.width, camera.height
        return Calibration("sphere", w, h, (w / (2 * np.pi),) * 2, (w / 2, h / 2))
    if camera.model not in _DISTORTION:
        raise refused(camera, format_name, "has a distortion that it cannot express")
    at = _DISTORTION[camera.model]
    K = calibration_matrix(camera.model, camera.params)
    named = dict(zip(at, camera.params[len(camera.params) - len(at) :].tolist(), strict=True))
    beyond = [name for name, value in named.items() if name.startswith("-") and value]
    if beyond:
        raise refused(camera, format_name, "has a prism or rational distortion, which it cannot express")
    k1, k2, k3, k4, p1, p2 = (named.get(name, 0.0) for name in ("k1", "k2", "k3", "k4", "p1", "p2"))
    return Calibration(
        "fisheye" if "FISHEYE" in camera.model else "frame",
        camera.width,
        camera.height,
        (float(K[0, 0]), float(K[1, 1])),
        (float(K[0, 2]), float(K[1, 2])),
        (k1, k2, k3, k4),
        (p1, p2),
    )


_DISTORTION: dict[str, tuple[str, ...]] = {
    "SIMPLE_PINHOLE": (),
    "PINHOLE": (),
    "SIMPLE_RADIAL": ("k1",),
    "RADIAL": ("k1", "k2"),
    "OPENCV": ("k1", "k2", "p1", "p2"),
    "FULL_OPENCV": ("k1", "k2", "p1", "p2", "k3", "-d1", "-d2", "-d3"),
    "SIMPLE_FISHEYE": (),
    "FISHEYE": (),
    "SIMPLE_RADIAL_FISHEYE": ("k1",),
    "RADIAL_FISHEYE": ("k1", "k2"),
    "OPENCV_FISHEYE": ("k1", "k2", "k3", "k4"),
    "THIN_PRISM_FISHEYE": ("k1", "k2", "p1", "p2", "k3", "k4", "-s1", "-s2"),
}
"""The last parameters of the models that fit in a `Calibration`; those with "-" must be zero."""


def refused(camera: Camera, format_name: str, why: str) -> InputError:
    """The error for a camera that a format cannot express."""
    return InputError(
        f"{format_name}: a {camera.model} camera {why}; write a COLMAP model instead", code="I114"
    )
