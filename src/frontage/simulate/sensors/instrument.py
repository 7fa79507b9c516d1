"""Properties of laser scanners: those that a user states, and the rest, which is drawn from the seed."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

_WAVELENGTH_SHARES = {532: 0.1, 905: 0.25, 1064: 0.15, 1550: 0.5}  # by nm, of the scanners in use


class InstrumentSpec(BaseModel):
    """A laser scanner; whatever is left out (None) is drawn from the seed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    ranging: Literal["pulsed", "phase"] | None = Field(None, description="pulsed or phase-shift ranging")
    wavelength: Literal[532, 905, 1064, 1550] | None = Field(
        None, description="nm; coated panes reflect more of it the longer it is"
    )
    sigma_range: float | None = Field(
        None, ge=0, le=0.1, description="m, range noise on a white surface 10 m away"
    )
    sigma_angle: float | None = Field(None, ge=0, le=5, description="mrad, noise of each of the two angles")
    divergence: float | None = Field(
        None, ge=0, le=10, description="mrad, full angle of the beam, 1/e2 of the power"
    )
    exit_beam: float | None = Field(
        None, ge=0, le=0.05, description="m, diameter of the leaving beam, 1/e2 of the power"
    )
    subrays: Literal[1, 7, 19, 37] = Field(19, description="rays that sample the beam's cross-section")
    echoes: Literal["first", "strongest", "last", "all"] | None = Field(
        None, description="which echoes of a beam are kept"
    )
    resolution: float | None = Field(
        None, gt=0, le=3, description="m, pulsed: echoes closer than this melt into one"
    )
    range_min: float = Field(0.6, ge=0, description="m, nothing nearer is measured")
    range_max: float = Field(150.0, gt=0, description="m, nothing farther is measured")
    range_dark: float | None = Field(
        None, gt=0, description="m, at which a surface that reflects 10 % is just detected"
    )
    strays: float | None = Field(None, ge=0, le=0.1, description="share of the beams that measure air")
    colour: bool = Field(True, description="points carry the colour of what they hit")
    spectral: float = Field(
        0.0, ge=0, le=1, description="how little reflectances have to do with colours: 0 = half, 1 = nothing"
    )
    wet: float = Field(0.0, ge=0, le=1, description="share of the porous surfaces that is damp")
    response: Literal["linear", "root", "log"] = Field(
        "linear", description="curve by which the intensity is recorded"
    )
    bits: int | None = Field(None, ge=4, le=16, description="of the recorded intensity; None: 12 or 16")
    moved: float = Field(
        0.0, ge=0, le=1, description="share of cars and pedestrians that stand elsewhere than in the photos"
    )

    @model_validator(mode="after")
    def _check_ranges(self) -> Self:
        if self.range_min >= self.range_max:
            raise ValueError(
                f"range_min ({self.range_min:g} m) must be smaller than range_max ({self.range_max:g} m)"
            )
        return self


class ScannerSpec(InstrumentSpec):
    """Terrestrial scans from stations in front of the houses, each a polar raster."""

    stations: int = Field(
        2, ge=1, le=100, description="scan positions, spread along the street unless `positions` says where"
    )
    positions: tuple[tuple[float, float], ...] | None = Field(
        None, min_length=1, description="m, positions [s, d] along the street and towards the houses"
    )
    height: float = Field(1.75, gt=0, le=20, description="m, of the scanner's centre above the ground")
    spacing: float = Field(0.02, gt=0.0005, le=1, description="m between neighbouring beams, 10 m away")
    lowest: float = Field(-50.0, ge=-90, lt=90, description="degrees, lowest beam above the horizon")
    highest: float = Field(75.0, gt=-90, le=90, description="degrees, highest beam above the horizon")
    field: float = Field(
        360.0, gt=0, le=360, description="degrees, horizontal field; less than 360 faces the houses"
    )
    pose: Literal["true", "approximate"] = Field(
        "true", description="approximate: the poses handed over come from GPS and a compass"
    )
    sigma_position: float = Field(1.5, ge=0, description="m per axis, of approximate poses")
    sigma_heading: float = Field(3.0, ge=0, le=90, description="degrees, of approximate poses")
    sigma_level: float = Field(0.1, ge=0, le=10, description="degrees, of approximate poses")

    @model_validator(mode="after")
    def _check_angles(self) -> Self:
        if self.lowest >= self.highest:
            raise ValueError(f"lowest ({self.lowest:g}) must be smaller than highest ({self.highest:g})")
        return self


class DriveSpec(InstrumentSpec):
    """A vehicle with two profile scanners, which drives once along the road of the scene."""

    speed: float = Field(7.0, gt=0, le=40, description="m/s")
    height: float = Field(2.4, gt=0.3, le=10, description="m, of the scanners above the road")
    lane: float | None = Field(None, description="m, offset of the track towards the houses; None: drawn")
    profile_rate: float = Field(100.0, gt=0, le=2000, description="profiles per second of each scanner")
    beams: int = Field(1000, ge=16, le=100_000, description="beams of one profile, all around")
    tilt: float = Field(45.0, ge=0, le=80, description="degrees between a profile and the cross-section")
    overrun: float = Field(
        10.0, ge=0, le=500, description="m driven before the first and after the last house"
    )
    start: float = Field(302_400.0, ge=0, description="s, gps_time of the first profile")
    offset: float = Field(0.03, ge=0, description="m per axis, one sigma of the trajectory's constant error")
    drift: float = Field(0.03, ge=0, description="m, one sigma per axis gained in 100 m of drive")
    drift_angle: float = Field(
        0.02, ge=0, description="degrees, one sigma of the slowly varying attitude error"
    )
    boresight: float = Field(
        0.01, ge=0, description="degrees per axis, one sigma of each scanner's mounting error"
    )


@dataclass(frozen=True)
class Instrument:
    """A scanner with all its properties; lengths in m, angles in rad. `InstrumentSpec` explains the others.

    exponent    b of the range noise `sigma_range (E / E_white,10m)^-b`, where E is the received energy
    near        m, range of the near-range roll-off 1 - exp(-(R / near)^2)
    falloff     exponent of the cosine of incidence in the diffuse reflection
    fine        m, phase-shift ranging: half of the shortest modulation wavelength
    coherence   phase-shift ranging: echoes whose modulation drops below this share are rejected
    spread      share of the echo's width that becomes range noise, which therefore grows with incidence
    gain        intensity of a white surface 10 m away
    speckle     relative noise of the intensity
    levels      number of steps of the recorded intensity
    response    curve by which it is recorded: "linear", "root" or "log"
    """

    ranging: str
    wavelength: int
    sigma_range: float
    exponent: float
    sigma_angle: float
    divergence: float
    exit_beam: float
    subrays: int
    echoes: str
    resolution: float
    fine: float
    coherence: float
    spread: float
    range_min: float
    range_max: float
    range_dark: float
    near: float
    falloff: float
    strays: float
    gain: float
    speckle: float
    levels: int
    response: str = "linear"

    def footprint(self, distance: float) -> float:
        """Return the diameter (m) of the beam at `distance` (m), at 1/e2 of the power."""
        return float(np.hypot(self.exit_beam, self.divergence * distance))


def draw_instrument(spec: InstrumentSpec, rng: np.random.Generator) -> Instrument:
    """Draw whatever `spec` leaves open.

    Every number is drawn in any case, so that stating one property does not change the others.
    """
    mobile = isinstance(spec, DriveSpec)
    phase = bool(rng.random() < 0.4) and not mobile
    ranging = spec.ranging or ("phase" if phase else "pulsed")
    pulsed = ranging == "pulsed"
    low, high = (0.003, 0.006) if mobile else (0.001, 0.003) if pulsed else (0.0004, 0.0012)
    sigma = rng.uniform(low, high)
    angle = rng.uniform(0.02, 0.05)
    divergence = rng.uniform(*((0.35, 0.7) if mobile else (0.25, 0.6)))
    wavelength = int(rng.choice(list(_WAVELENGTH_SHARES), p=list(_WAVELENGTH_SHARES.values())))
    kept = str(rng.choice(["first", "strongest"]))
    return Instrument(
        ranging=ranging,
        wavelength=spec.wavelength or wavelength,
        sigma_range=_stated_or(spec.sigma_range, sigma),
        exponent=float(rng.uniform(0.2, 0.45)),
        sigma_angle=1e-3 * _stated_or(spec.sigma_angle, angle),
        divergence=1e-3 * _stated_or(spec.divergence, divergence),
        exit_beam=_stated_or(spec.exit_beam, rng.uniform(0.0035, 0.007)),
        subrays=spec.subrays,
        echoes=spec.echoes or ("all" if mobile else kept if pulsed else "strongest"),
        resolution=_stated_or(spec.resolution, rng.uniform(0.2, 0.6)),
        fine=float(rng.uniform(0.6, 1.5)),
        coherence=float(rng.uniform(0.4, 0.75)),
        spread=float(rng.uniform(0.1, 0.3)),
        range_min=spec.range_min,
        range_max=spec.range_max,
        range_dark=_stated_or(spec.range_dark, float(np.exp(rng.uniform(np.log(25), np.log(100))))),
        near=float(rng.uniform(1.0, 3.0)),
        falloff=float(rng.uniform(0.8, 1.3)),
        strays=_stated_or(spec.strays, 10 ** rng.uniform(-5.5, -4)),
        gain=float(rng.uniform(0.3, 1.0)),
        speckle=float(rng.uniform(0.01, 0.05)),
        levels=_levels(spec.bits, int(rng.choice([4096, 65536]))),
        response=spec.response,
    )


def _levels(bits: int | None, drawn: int) -> int:
    return drawn if bits is None else 1 << bits


def _stated_or(value: float | None, drawn: float) -> float:
    return float(drawn if value is None else value)
