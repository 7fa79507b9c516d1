"""Sun and sky: the direction, colour and amount of light.

Unit: the radiance of a white diffuse surface that lies level under the open sky on a clear day is about 1.
Albedo times irradiance is radiance (the factor 1 / pi is part of the unit).
"""

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics import noise
from frontage.simulate.scene import Scene

_SUN = np.array([1.0, 0.93, 0.80])  # colour of the sun 40 degrees up
_BLUE, _GREY = np.array([0.21, 0.29, 0.45]), np.array([0.40, 0.42, 0.45])  # zenith, clear and overcast
_HAZE = np.array([0.50, 0.55, 0.60])
_CLOUDS = (3.7, 1.9, 0.9, 0.45, 0.21, 0.1)  # wavelengths, in heights of the layer
_BOUNCE = 0.22  # reflectance of a street as a whole


class LightSpec(BaseModel):
    """Sun and sky; whatever is left out (None) is drawn from the scene's seed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    sun_elevation: float | None = Field(default=None, gt=3, le=90, description="degrees above the horizon")
    sun_azimuth: float | None = Field(
        default=None,
        ge=-180,
        le=180,
        description="from the street, facing the near houses; positive = right, degrees",
    )
    overcast: float | None = Field(default=None, ge=0, le=1, description="0 = clear sky, 1 = no sun")


@dataclass(frozen=True, eq=False)
class Light:
    """The light on a scene; colours are linear RGB (3,).

    to_sun    (3,) unit vector, local
    sun       irradiance of a surface that faces the sun
    sky       mean radiance of the sky
    bounce    radiance of the lit surfaces around, which fills the directions that are not free
    overcast  0 = clear sky, 1 = no sun
    seed      seed of the clouds and of the horizon
    """

    to_sun: Float
    sun: Float
    sky: Float
    bounce: Float
    overcast: float
    seed: int

    def ambient(self, normals: Float, openness: Array) -> Array:
        """Return the irradiance (n, 3) float32, without direct sun, of surfaces with unit normals (n, 3).

        `openness` (n,) is the cosine-weighted share of the hemisphere above a surface that is free, its sky
        view factor.
        """
        up = np.clip(normals[:, 2], -1, 1).astype(np.float32)
        free = openness.astype(np.float32)
        sky = free[:, None] * np.float32(self.sky) * (1 + np.float32(0.15) * up)[:, None]
        return np.asarray(sky + (1 - free)[:, None] * np.float32(self.bounce))


def draw_light(scene: Scene, spec: LightSpec) -> Light:
    """Draw the light on a scene: the sun stands in front of either side of the street, or behind clouds."""
    rng = np.random.default_rng([scene.seed, 0x5047])
    elevation = np.radians(rng.uniform(28, 60) if spec.sun_elevation is None else spec.sun_elevation)
    drawn = rng.uniform(-75, 75) + 180 * (rng.random() < 0.75)
    azimuth = np.radians(drawn if spec.sun_azimuth is None else spec.sun_azimuth)
    cover = rng.random()
    overcast = float(max(0.0, (cover - 0.55) / 0.45)) if spec.overcast is None else spec.overcast
    level = np.array([np.sin(azimuth), np.cos(azimuth)]) * np.cos(elevation)
    to_sun = scene.local_from_street.R @ np.array([*level, np.sin(elevation)])
    red = np.array([1.0, 0.97, 0.88]) ** (1 / max(np.sin(elevation), 0.15) - 1.5)
    sun = 0.95 * _SUN * red * (1 - overcast) ** 2
    sky = (1 - overcast) * (0.75 * _BLUE + 0.25 * _HAZE) * 0.75 + overcast * _GREY
    level_light = sky + sun * np.sin(elevation)
    bounce = _BOUNCE * np.array([1.05, 1.0, 0.93]) * (0.5 * level_light + 0.25 * sky)
    return Light(to_sun, sun, sky, bounce, overcast, scene.seed & 0x7FFFFFFF)


def sky_radiance(light: Light, directions: Float) -> Array:
    """Return the radiance (n, 3) float32 along unit directions (n, 3) that meet nothing.

    It consists of sky, clouds, the glow around the sun, and far roofs at the horizon.
    """
    d = np.asarray(directions)
    up = d[:, 2].astype(np.float32)
    high = np.clip(up, 0, 1)[:, None] ** np.float32(0.45)
    clear = np.float32(_HAZE) * (1 - high) + np.float32(_BLUE) * high
    glow = np.clip(d @ light.to_sun, 0, 1).astype(np.float32)
    clear += (0.25 * glow**8 + 0.9 * glow**90)[:, None] * np.float32(light.sun)
    grey = np.float32(_GREY) * (0.8 + 0.4 * high)
    rgb = clear + (grey - clear) * _clouds(light, d)[:, None]
    return _horizon(light, d, rgb)


def _clouds(light: Light, d: Float) -> Array:
    """Returns the cloud cover (n,) 0..1 from noise on a level layer."""
    height = np.maximum(d[:, 2], 0.06)
    x, y = ((d[:, k] / height).astype(np.float32) for k in (0, 1))
    seed = np.full(len(d), light.seed, np.uint32)
    field = noise.fractal(x, y, _CLOUDS, seed=seed, salt=7, blur=np.zeros(len(d), np.float32), gain=0.7)
    cover = np.clip(0.45 * field + 0.1 + 1.6 * light.overcast, 0, 1)
    return np.asarray(cover * np.clip((d[:, 2] - 0.02) / 0.15, 0, 1), np.float32)


def _horizon(light: Light, d: Float, rgb: Array) -> Array:
    """Adds far roofs and trees in the haze, up to some degrees above the horizon, and the ground below it."""
    azimuth = np.arctan2(d[:, 1], d[:, 0]).astype(np.float32)
    seed = np.full(len(d), light.seed, np.uint32)
    line = 0.03 + 0.007 * noise.fractal(
        azimuth,
        0 * azimuth,
        (0.5, 0.17, 0.06),
        seed=seed,
        salt=9,
        blur=np.zeros(len(d), np.float32),
    )
    below = np.clip((line - d[:, 2].astype(np.float32)) / 0.002 + 0.5, 0, 1)[:, None]
    ground = np.float32(light.sky * 0.35 + light.bounce * 0.5)
    return np.asarray(rgb + (ground - rgb) * below, np.float32)
