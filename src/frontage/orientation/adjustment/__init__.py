"""Bundle adjustment with control, rigs, self-calibration and honest statistics.

A sparse least-squares adjustment with the Schur complement on the object points. Beyond the values it gives
the marginal covariance of every pose, camera and point, the redundancy and the detectable bias of every
observation, variance components per group, and check points. The entry function is `adjust`, its input
`Network`, its result `Adjustment`.
"""

from frontage.orientation.adjustment.bundle import adjust
from frontage.orientation.adjustment.checks import CheckPoints, check_points, split_control
from frontage.orientation.adjustment.covariance import NotDetermined
from frontage.orientation.adjustment.dependence import Dependence
from frontage.orientation.adjustment.network import (
    ImageObservations,
    Network,
    Photos,
    PointObservations,
    control_rows,
    held_mount,
)
from frontage.orientation.adjustment.options import AdjustmentOptions
from frontage.orientation.adjustment.result import Adjustment

__all__ = [
    "Adjustment",
    "AdjustmentOptions",
    "CheckPoints",
    "Dependence",
    "ImageObservations",
    "Network",
    "NotDetermined",
    "Photos",
    "PointObservations",
    "adjust",
    "check_points",
    "control_rows",
    "held_mount",
    "split_control",
]
