"""The adjustment problem: surfels, model, priors and ties, and how well the model itself is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.registration.options import RegistrationOptions
from frontage.registration.result import PosePrior
from frontage.registration.walls import ModelPatch, ModelWalls
from frontage.solve.surfels import Surfels

_CORNER = 0.6  # sigma of a corner and of a patch, relative to that of the building
_ROOF = 0.3  # sigma of a roof, relative to that of the building's height
_ROOF_TILT_RAD = np.radians(1.0)  # rad, one sigma of a roof's slope, for a height known to 15 cm
_ROOF_HEIGHT_M = 0.15  # m
_ASLANT = 0.5  # squared cosine with one surface's normal from which on it determines a direction: 45 degrees
_CLOSE_M = 0.01 / 2.576  # m, sigma for which 99 % of errors are below a centimetre


@dataclass(frozen=True, eq=False)
class Pairs:
    """Surfels of two scans on one surface.

    s, t  (m,) numbers of the scans; `i`, `k` (m,) surfels of each
    area  (m,) m2 that both have in common
    """

    s: Int
    t: Int
    i: Int
    k: Int
    area: Float


@dataclass(frozen=True, eq=False)
class Link:
    """Scans s and t share one correction, except for a drift of `sigma` (6,): m half way between, and rad."""

    s: int
    t: int
    sigma: Float


@dataclass(frozen=True, eq=False)
class Problem:
    """What stays the same during an adjustment.

    pieces  surfels of every scan, in the coordinates that it was given
    walls   the city model as planes
    priors  of every scan
    links   between scans that are parts of one drive
    """

    pieces: Sequence[Surfels]
    walls: ModelWalls
    priors: Sequence[PosePrior]
    options: RegistrationOptions
    links: tuple[Link, ...] = ()

    @property
    def model_sigma(self) -> Float:
        """Prior sigmas (b + j, 3) of the model's errors.

        The first b rows are shifts of the buildings (m), the others offset (m), turn and lean (rad) of the
        patches.
        """
        o = self.options
        plan, height = max(o.sigma_model, 1e-4), max(o.sigma_height, 1e-4)
        buildings = np.tile([plan, plan, height], (len(self.walls.names), 1))
        patches = [
            self._wall_sigma(p, plan) if p.kind == "wall" else self._roof_sigma(p, height)
            for p in self.walls.patches
        ]
        return np.vstack([buildings, np.array(patches).reshape(-1, 3)])

    def _wall_sigma(self, patch: ModelPatch, plan: float) -> list[float]:
        """Sigmas of a wall's offset (m), turn and lean (rad); `plan` m is that of its building."""
        return [
            _CORNER * plan / 1.4,
            _CORNER * plan * 1.4 / max(patch.length, 1.0),
            np.radians(self.options.sigma_lean) + 1e-5,
        ]

    def _roof_sigma(self, patch: ModelPatch, height: float) -> list[float]:
        """Sigmas of a roof's offset (m), turn and slope (rad); `height` m is that of its building."""
        return [
            _ROOF * height,
            _ROOF * height / max(patch.length, 1.0),
            _ROOF_TILT_RAD * min(1, height / _ROOF_HEIGHT_M),
        ]

    @property
    def observable(self) -> Float:
        """Sigma (3,) m per axis up to which a shift is observable.

        It is what one surface of the model tells of a direction that it meets at 45 degrees; for an exact
        model, a centimetre with 99 % confidence.
        """
        o = self.options
        plan = o.sigma_model**2 * (1 + (_CORNER / 1.4) ** 2)
        height = o.sigma_height**2 * (1 + _ROOF**2)
        variance = np.array([plan, plan, height]) / _ASLANT + _CLOSE_M**2
        return np.asarray(np.minimum(np.sqrt(variance), o.observable))
