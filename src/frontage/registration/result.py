"""What registration takes and gives: pose priors, registered scans, wall offsets."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate


@dataclass(frozen=True, eq=False)
class PosePrior:
    """What GPS, compass and level say of one scan, which they have already placed.

    position        (3,) m local, where the instrument stands according to them; the scan turns about it
    sigma_position  (3,) m, one sigma per axis
    sigma_heading   rad
    sigma_level     rad, of each of the two tilts

    Raises ValueError unless the position is finite and all sigmas are above zero.
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
        """Sigmas (6,) of position (m) and rotation (rad), in the order of a pose's tangent."""
        return np.array([*self.sigma_position, self.sigma_level, self.sigma_level, self.sigma_heading])


@dataclass(frozen=True, eq=False)
class Direction:
    """One principal direction of a pose: what is known of it, and whether the data say so.

    kind         "shift" (sigma in m) or "turn" (rad)
    axis         (3,) unit vector, local: direction of the shift, or axis of the turn
    sigma        of the result
    sigma_prior  of GPS, compass and level along the same axis
    observable   the data determine it as well as the model's surfaces are known
    weak         not observable, but `sigma` comes from the data; if neither holds, the prior remains
    """

    kind: str
    axis: Float
    sigma: float
    sigma_prior: float
    observable: bool
    weak: bool = False


@dataclass(frozen=True, eq=False)
class Alternative:
    """Another place that explains the data nearly as well.

    shift  (3,) m of the point `about`, from the chosen place
    turn   rad about the vertical through that point, from the chosen place
    score  relative to the chosen place (1 = as good)
    about  (3,) m local
    scans  numbers of the scans, which are tied to one another
    """

    shift: Float
    turn: float
    score: float
    about: Float
    scans: tuple[int, ...]

    def at(self, position: Float) -> Float:
        """Returns shift (m) and turn (rad), (6,), of an instrument that now stands at `position` (3,) m."""
        x, y, _ = position - self.about
        arm = self.turn * np.array([-y, x, 0.0])
        return np.concatenate([self.shift + arm, [0.0, 0.0, self.turn]])


@dataclass(frozen=True, eq=False)
class RegisteredScan:
    """The result for one scan.

    local_from_given  corrects the coordinates of the scan as given; covariance (6, 6), m and rad
    position          (3,) m local, of the instrument after the correction
    covariance        (6, 6) of that position and of the rotation about it (m, rad), alternatives included
    directions        principal directions of the pose
    explained         share of the scan's wall area that lies on walls of the model (within 30 cm)
    residual          m, robust standard deviation of the surfels about their (corrected) walls
    pieces            number of surfels that took part; `area` m2 of them
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
        """The directions that the data determine poorly (weak) or not at all."""
        return tuple(d for d in self.directions if not d.observable)


@dataclass(frozen=True, eq=False)
class WallOffset:
    """Where a wall of the model really is.

    building, surface  ids of the model; `kind` "wall" or "roof"
    offset             m along its outward normal at its middle; `sigma` m
    turn, lean         rad, against the model
    area               m2 that was seen
    """

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

    scans         one result each
    alternatives  other places that explain scans nearly as well; the scans of each are tied to one another
    walls         offsets of the model's walls and roofs
    agreement     m, robust standard deviation between scans where they overlap; NaN for a single scan
    overlap       number of pairs of surfels that tell it
    reason        why the adjustment stopped
    notes         sentences for the report
    """

    scans: tuple[RegisteredScan, ...]
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
