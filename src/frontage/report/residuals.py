"""The residuals of control points, drawn in the frame of every photo."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.report.plans import magnification

_SIDE = 204.0  # px, longer side of a frame
_LONG = 16.0  # px, nine of ten vectors are no longer
_MOST = 60  # photos that are shown


@dataclass(frozen=True)
class ResidualPlot:
    """A photo's frame in px, its control points and vectors as paths, rms and number in words."""

    photo: str
    verdict: str
    caption: str
    width: float
    height: float
    points: str
    vectors: str


@dataclass(frozen=True)
class ResidualPlots:
    """The plots, how much longer than true their vectors are, and the number of photos without a plot."""

    plots: tuple[ResidualPlot, ...]
    magnified: int
    left_out: int


def residual_plots(photos: Sequence[dict[str, Any]]) -> ResidualPlots:
    """Plots of the first sixty photos, with the same magnification relative to their frames."""
    shown = photos[:_MOST]
    residuals = [np.array(p["residuals"], np.float64).reshape(-1, 4) * _scale(p) for p in shown]
    lengths = np.concatenate([np.empty(0), *(np.hypot(r[:, 2], r[:, 3]) for r in residuals)])
    magnified = magnification(float(np.quantile(lengths, 0.9)), _LONG) if len(lengths) else 1
    plots = [_plot(p, r, magnified) for p, r in zip(shown, residuals, strict=True)]
    return ResidualPlots(tuple(plots), magnified, len(photos) - len(shown))


def _scale(photo: dict[str, Any]) -> float:
    """Px of the figure per px of the photo."""
    return _SIDE / float(max(photo["camera"]["width"], photo["camera"]["height"]))


def _plot(photo: dict[str, Any], residuals: Float, magnified: int) -> ResidualPlot:
    """The plot of one photo; `residuals` (n, 4) are place and vector in px of the figure."""
    scale = _scale(photo)
    ends = np.column_stack([residuals[:, :2], magnified * residuals[:, 2:]]).tolist()
    return ResidualPlot(
        photo["photo"],
        photo["verdict"],
        _caption(photo, len(residuals)),
        photo["camera"]["width"] * scale,
        photo["camera"]["height"] * scale,
        "".join(f"M{x:.1f} {y:.1f}h0" for x, y, _, _ in ends),
        "".join(f"M{x:.1f} {y:.1f}l{dx:.1f} {dy:.1f}" for x, y, dx, dy in ends),
    )


def _caption(photo: dict[str, Any], drawn: int) -> str:
    number = photo["control_points"]
    if not number:
        return "no control points"
    rms = "" if photo["control_rms"] is None else f"rms {photo['control_rms']:.2f} px, "
    return f"{rms}{number:,} points" + (f", {drawn:,} of them drawn" if drawn < number else "")
