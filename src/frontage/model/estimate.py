"""A value with its uncertainty, and the value that stands for a failure."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

import numpy as np

from frontage.geometry.arrays import Float, readonly

T = TypeVar("T")


class Provenance(StrEnum):
    """Where an estimate comes from."""

    MEASURED = "measured"
    POOLED = "pooled"  # estimated jointly from similar elements
    INFERRED = "inferred"  # concluded from symmetry, never seen
    GIVEN = "given"  # stated by the user or a file


@dataclass(frozen=True, eq=False)
class Estimate(Generic[T]):
    """A value, its covariance (k, k) in squared units of its parameters, and its degrees of freedom.

    For a `Rigid3` the covariance is (6, 6), order translation (m), rotation (rad); see geometry.rigid.
    `dof` is the *effective* redundancy, in which correlated residuals count only once
    (docs/methods/facades.md).
    """

    value: T
    covariance: Float
    dof: float
    provenance: Provenance = Provenance.MEASURED

    def __post_init__(self) -> None:
        c = np.atleast_2d(np.asarray(self.covariance, np.float64))
        object.__setattr__(
            self, "covariance", readonly(c, (c.shape[0], c.shape[0]), np.float64, "covariance")
        )

    @property
    def sigma(self) -> Float:
        """Standard errors (k,): the square roots of the diagonal of the covariance."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class Failed:
    """What one item of a batch returns when it fails; it is falsy.

    code     one of `frontage.errors.CODES`
    message  what failed and why
    hint     what to do
    """

    code: str
    message: str
    hint: str = ""

    def __bool__(self) -> bool:
        return False
