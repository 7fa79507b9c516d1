"""The options of the bundle adjustment."""

from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.geometry.arrays import Bool

Loss = Literal["none", "huber", "cauchy"]


class AdjustmentOptions(BaseModel):
    """How outliers are found, and whether the stated standard errors are believed.

    First the block is adjusted with a robust loss, whose scale comes from the residuals themselves; then
    observations beyond `critical` are put aside, and the rest is adjusted by least squares, tested
    observation by observation, with the variance of every group estimated.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    loss: Loss = Field(default="cauchy", description="robust loss of the first phase; none leaves it out")
    losses: dict[int, Loss] = Field(
        default_factory=dict, description="loss of single groups, where it differs from `loss`"
    )
    least_squares: bool = Field(
        default=True,
        description="end with least squares; otherwise the robust weights stay, and the covariances "
        "are approximate",
    )
    snooping: bool = Field(default=True, description="test every observation and remove what fails")
    critical: float = Field(
        default=4.0,
        gt=1,
        le=10,
        description="sigmas of a single normal variable beyond which an observation fails its test",
    )
    variance_components: bool = Field(
        default=True, description="estimate the variance of every group of observations"
    )
    known: frozenset[int] = Field(
        default=frozenset(), description="groups whose stated standard errors are believed all the same"
    )
    least_redundancy: float = Field(
        default=20.0, ge=1, description="redundancy of a group that is needed to estimate its variance"
    )
    rounds: int = Field(default=12, ge=1, le=100, description="most rounds of tests and variance estimation")
    iterations: int = Field(default=50, ge=1, le=1000, description="most steps of one minimisation")

    def estimates(self, groups: int) -> Bool:
        """For which of a number of groups the variance is estimated, (g,)."""
        return np.array([self.variance_components and g not in self.known for g in range(groups)], bool)

    def loss_of(self, group: int) -> Loss:
        """The robust loss of a group."""
        return self.losses.get(group, self.loss)
