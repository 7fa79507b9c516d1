"""One finished minimisation with everything that its statistics need."""

from dataclasses import dataclass

from frontage.geometry.arrays import Float
from frontage.orientation.adjustment.covariance import Precision
from frontage.orientation.adjustment.datum import Datum
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.linearise import Linearised
from frontage.orientation.adjustment.minimise import Minimum
from frontage.orientation.adjustment.normal import NormalEquations


@dataclass(frozen=True, eq=False)
class Fit:
    """A minimum, the normal equations there, their datum and precision, and the variance factors (g,)."""

    minimum: Minimum
    layout: Layout
    equations: NormalEquations
    datum: Datum
    precision: Precision
    factors: Float

    @property
    def rows(self) -> Linearised:
        """The linearised rows."""
        return self.equations.rows

    @property
    def observations(self) -> int:
        """The number of scalar observations, priors included."""
        priors = sum(len(p[1]) for p in self.rows.priors if p is not None)
        own = 2 * len(self.layout.rows) + len(self.layout.surface_rows)
        return int(own + priors + (self.rows.cameras > 0).sum() + len(self.rows.mount_miss))

    @property
    def dof(self) -> int:
        """Observations minus unknowns plus the defect of the datum."""
        unknowns = self.layout.columns + 3 * len(self.layout.points)
        return self.observations - unknowns + self.datum.defect
