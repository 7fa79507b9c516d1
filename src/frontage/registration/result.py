"""What registration takes and gives, in the words of surveyors."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate


@dataclass(frozen=True, eq=False)
class PosePrior:
    """What GPS, compass and level say of one scan, which is already placed by them.

    position        (3,) m local, where the instrument stands according to them; the scan turns about it
    sigma_position  (3,) m, one sigma per axis
    sigma_heading   rad; sigma_level rad, of each of the two tilts
    """

    position: Float
    sigma_position: Float
    sigma_heading: float
    sigma_level: float

    def __post_init__(self) -> None:
        freeze(self, position=((3,), np.float64), sigma_position=((3,), np.float64))
        values = np.array([*self.sigma_position, self.sigma_heading, self.sigma_level])
        if not (np.isfinite(values).all() and (values > 0).all() and np.isfinite(self.position).all()):
            raise ValueError("a pose prior needs a finite position and sigmas above zero")

    @property
    def sigma(self) -> Float:
        """Sigmas (6,) of position (m) and rotation (rad) in the order of a pose's tangent."""
        return np.array([*self.sigma_position, self.sigma_level, self.sigma_level, self.sigma_heading])


@dataclass(frozen=True, eq=False)
class Direction:
    """One principal direction of a pose: what is known of it, and whether the data say so.

    kind        "shift" (sigma in m) or "turn" (rad)
    axis        (3,) unit vector, local: of the shift, or about which it turns
    sigma       of the result; `sigma_prior` of GPS, compass and level along the same axis
    observable  the data determine it as well as the model's surfaces are known
    weak        not observable, but the data tell it: `sigma` is theirs. Neither: the prior stands
    """

    kind: str
    axis: Float
    sigma: float
    sigma_prior: float
    observable: bool
    weak: bool = False


@dataclass(frozen=True, eq=False)
class Alternative:
    """Another place that explains the data nearly as well, of `scans` (their numbers), which hang together:
    `shift` (3,) m of the point `about` (3,) m local, `turn` rad about the vertical through it, both from the
    chosen place; `score` relative to it (1 = as good)."""

    shift: Float
    turn: float
    score: float
    about: Float
    scans: tuple[int, ...]

    def at(self, position: Float) -> Float:
        """Shift (m) and turn (rad), (6,), of an instrument that the chosen place has at `position` (3,)."""
        x, y, _ = position - self.about
        arm = self.turn * np.array([-y, x, 0.0])
        return np.concatenate([self.shift + arm, [0.0, 0.0, self.turn]])


@dataclass(frozen=True, eq=False)
class Registered:
    """One scan's result.

    local_from_given  corrects the coordinates of the scan as given; covariance (6, 6), m and rad
    position          (3,) m local, of the instrument after the correction; `covariance` (6, 6) of that place
                      and of the rotation about it (m, rad), other places that explain the data included
    explained         share of the scan's wall area that lies on walls of the model (within 30 cm)
    residual          m, robust standard deviation of the wall pieces about their (corrected) walls
    pieces            how many flat pieces took part, and `area` m2 of them
    """

    name: str
    local_from_given: Estimate[Rigid3]
    position: Float
    covariance: Float
    directions: tuple[Direction, ...]
    explained: float
    residual: float
    pieces: int
    area: float

    @property
    def unobservable(self) -> tuple[Direction, ...]:
        """The directions that the data tell poorly (weak) or not at all."""
        return tuple(d for d in self.directions if not d.observable)


@dataclass(frozen=True, eq=False)
class WallOffset:
    """Where a wall of the model really is: `offset` m along its outward normal at its middle, its sigma,
    its turn and lean against the model (rad), and the area seen (m2)."""

    building: str
    surface: str
    kind: str
    offset: float
    sigma: float
    turn: float
    lean: float
    area: float


@dataclass(frozen=True, eq=False)
class Registration:
    """All scans against one city model.

    ambiguous     another place is nearly as good; `alternatives` are of scans that hang together
    agreement     m, robust standard deviation between scans where they overlap; NaN for a single scan
    reason        why the adjustment stopped
    """

    scans: tuple[Registered, ...]
    alternatives: tuple[Alternative, ...]
    walls: tuple[WallOffset, ...]
    agreement: float
    overlap: int
    reason: str
    notes: tuple[str, ...] = ()

    @property
    def ambiguous(self) -> bool:
        """Whether another place explains the data nearly as well."""
        return len(self.alternatives) > 0
