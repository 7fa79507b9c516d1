"""Specifications of photographs: the camera, the places to stand, the errors of GPS and compass."""

from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.geometry.camera import MODELS, parameter_count
from frontage.model import Camera
from frontage.simulate.optics.light import LightSpec

FORBID = ConfigDict(extra="forbid", frozen=True)
FILM_MM = 36.0
"""Width of the film that 35 mm equivalent focal lengths refer to."""


class Standpoint(BaseModel):
    """The place and direction of one photo, in the street frame."""

    model_config = FORBID

    along: float = Field(description="position along the street, m")
    across: float = Field(description="position across it, m; 0 = the near facades, negative = on the street")
    height: float = Field(default=1.6, ge=0.2, le=60, description="above the ground, m")
    heading: float = Field(
        default=0.0, ge=-180, le=180, description="0 = at the near side, positive = right, degrees"
    )
    pitch: float = Field(default=0.0, ge=-80, le=80, description="upward tilt, degrees")
    roll: float = Field(default=0.0, ge=-180, le=180, description="clockwise, degrees")


class CameraSpec(BaseModel):
    """Photos of a simulated street; whatever is left out (None) is drawn or derived."""

    model_config = FORBID

    model: str = Field(default="OPENCV", description="COLMAP camera model")
    width: int = Field(default=4000, ge=16, le=12000, description="px")
    height: int = Field(default=3000, ge=16, le=12000, description="px")
    focal: float = Field(default=24.0, gt=3, le=400, description="focal length, mm of 35 mm film")
    params: tuple[float, ...] | None = Field(
        default=None, description="COLMAP parameters; None: drawn around `focal`"
    )
    layout: Literal["walk", "places"] = Field(
        default="walk", description="a walk along the street, or `places`"
    )
    places: tuple[Standpoint, ...] = Field(
        default=(), description="where photos are taken with layout = places"
    )
    side: int = Field(default=0, ge=0, le=1, description="side of the street that is photographed")
    spacing: float | None = Field(
        default=None, gt=0.1, le=50, description="m between stops; None: 75 % overlap"
    )
    distance: float | None = Field(
        default=None, gt=1, le=60, description="m to the facades; None: across the street"
    )
    eye: float = Field(default=1.65, ge=0.3, le=12, description="height of the camera above the ground, m")
    headings: tuple[float, ...] = Field(
        default=(0.0,), min_length=1, description="views at each stop, degrees"
    )
    pitches: tuple[float, ...] = Field(
        default=(12.0,), min_length=1, description="upward tilts at each stop, degrees"
    )
    most: int | None = Field(
        default=None, ge=1, le=5000, description="largest number of photos; the walk is thinned"
    )
    sigma_position: float = Field(default=1.5, ge=0, le=20, description="of the given position, m per axis")
    sigma_heading: float = Field(default=2.5, ge=0, le=40, description="of the given heading, degrees")
    sigma_level: float = Field(default=0.5, ge=0, le=10, description="of the given pitch and roll, degrees")
    samples: int = Field(default=5, ge=1, le=64, description="samples in a pixel that edges run through")
    psf: float = Field(default=0.5, ge=0, le=4, description="one sigma of the lens blur, px")
    vignetting: float = Field(default=0.35, ge=0, le=0.9, description="loss of light in the corners, share")
    exposure_jitter: float = Field(default=0.25, ge=0, le=2, description="one sigma, exposure values")
    white_balance_jitter: float = Field(
        default=0.04, ge=0, le=0.3, description="one sigma of red and blue, share"
    )
    read_noise: float = Field(default=4.0, ge=0, le=200, description="electrons")
    full_well: float = Field(default=12000.0, ge=200, description="electrons of a saturated pixel")
    light: LightSpec = Field(default=LightSpec(), description="sun and sky")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.model not in MODELS:
            raise ValueError(f"camera model {self.model!r} is not known; use one of {', '.join(MODELS)}")
        if self.params is not None and len(self.params) != parameter_count(self.model):
            raise ValueError(
                f"a {self.model} camera has {parameter_count(self.model)} parameters, not {len(self.params)}"
            )
        if self.layout == "places" and not self.places:
            raise ValueError('layout = "places" needs at least one entry in places')
        if self.layout == "walk" and self.places:
            raise ValueError('places are only used with layout = "places"; add that or leave them out')
        return self


def make_camera(spec: CameraSpec, seed: int) -> Camera:
    """Return the camera of `spec`; without `params`, a typical lens of its kind is drawn from `seed`.

    The principal point is some pixels off the middle, the two focal lengths agree to 0.2 permille, and the
    distortion is a few per cent in the corners.

    Raises OptionError for `params` of a camera that sees nothing in the middle of its picture.
    """
    w, h = spec.width, spec.height
    if spec.params is not None:
        camera = Camera(spec.model, w, h, np.array(spec.params, np.float64))
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = camera.ray(np.array([[w / 2 - 0.5, h / 2], [w / 2 + 0.5, h / 2]]))
        if not np.isfinite(ahead).all():
            raise OptionError(
                f"a {spec.model} camera with params {spec.params} sees nothing in the middle of a picture of"
                f" {w} x {h} px; check focal length and principal point"
            )
        return camera
    if spec.model == "EQUIRECTANGULAR":
        return Camera(spec.model, w, h, np.array([w, h], np.float64))
    rng = np.random.default_rng([seed, 0xCA3E6A])
    f = spec.focal / FILM_MM * max(w, h) * (1 + 0.01 * rng.normal())
    shift = np.array([w, h]) * (0.5 + 0.004 * rng.normal(size=2))
    bend = rng.normal(size=12)
    lens = _lens(spec.model, bend)
    focals = [f] if parameter_count(spec.model) - len(lens) == 3 else [f, f * (1 + 2e-4 * bend[11])]
    return Camera(spec.model, w, h, np.array([*focals, *shift, *lens], np.float64))


def _lens(model: str, bend: Float) -> list[float]:
    """Returns the distortion parameters of a camera model, from twelve normally distributed numbers."""
    k1, k2, k3, k4 = -0.06 + 0.01 * bend[0], 0.02 + 0.004 * bend[1], 0.002 * bend[2], 0.0005 * bend[3]
    p1, p2 = 3e-4 * bend[4], 3e-4 * bend[5]
    s = [2e-4 * b for b in bend[6:10]]
    return {
        "SIMPLE_PINHOLE": [],
        "PINHOLE": [],
        "SIMPLE_RADIAL": [k1],
        "RADIAL": [k1, k2],
        "OPENCV": [k1, k2, p1, p2],
        "FULL_OPENCV": [k1, k2, p1, p2, k3, 0.002 * bend[6], 0.001 * bend[7], k4],
        "SIMPLE_FISHEYE": [],
        "FISHEYE": [],
        "SIMPLE_RADIAL_FISHEYE": [0.2 * k1],
        "RADIAL_FISHEYE": [0.2 * k1, 0.2 * k2],
        "OPENCV_FISHEYE": [0.2 * k1, 0.2 * k2, 0.2 * k3, 0.2 * k4],
        "THIN_PRISM_FISHEYE": [0.2 * k1, 0.2 * k2, p1, p2, 0.2 * k3, 0.2 * k4, s[0], s[1]],
        "RAD_TAN_THIN_PRISM_FISHEYE": [0.2 * k1, 0.2 * k2, 0.2 * k3, k4 * 0.2, 0.0, 0.0, p1, p2, *s],
        "FOV": [0.6 + 0.05 * float(bend[0])],
        "SIMPLE_DIVISION": [k1],
        "DIVISION": [k1],
    }[model]
