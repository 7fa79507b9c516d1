"""What is known of the frame and the bars of an opening, as attributes of its surface in a city model."""

from collections.abc import Sequence

import numpy as np

from frontage.model import AXES, Bar, Estimate, Opening

Value = str | float | int
_DIGITS, _SIGMA_DIGITS = 4, 5  # after the point: 0.1 mm, 0.01 mm


def attributes_of_glazing(opening: Opening) -> dict[str, Value]:
    """Returns counts, widths and positions of the bars, and the width of the frame.

    Where the layout is not known there are no counts, and `bars` says why. Positions are m from the left or
    the lower border of the opening to the centre lines, one after the other in one text, like the widths.
    """
    glazing = opening.glazing
    if glazing is None:
        return {"bars": "not measured"}
    out: dict[str, Value] = {}
    if glazing.resolved:
        out |= dict(zip(("n_vertical", "n_horizontal"), glazing.counts, strict=True))
        out["bars_confidence"] = round(float(glazing.confidence), _DIGITS)
        for axis, border in zip(AXES, opening.ring.min(0).tolist(), strict=True):
            out |= _bars(axis, [b for b in glazing.bars if b.axis == axis], border)
    else:
        out["bars"] = f"not resolved: {glazing.note}" if glazing.note else "not resolved"
    return out | estimated("frame_width", glazing.frame_width) | estimated("frame_depth", glazing.depth)


def estimated(name: str, estimate: Estimate[float] | None) -> dict[str, Value]:
    """Returns a value with its standard error as two attributes; what was not measured is left out."""
    if estimate is None:
        return {}
    out: dict[str, Value] = {name: round(float(estimate.value), _DIGITS)}
    if np.isfinite(estimate.sigma[0]):
        out[f"sigma_{name}"] = round(float(estimate.sigma[0]), _SIGMA_DIGITS)
    return out


def _bars(axis: str, bars: Sequence[Bar], border: float) -> dict[str, Value]:
    """Returns the bars of one axis, in the order in which they stand."""
    if not bars:
        return {}
    ordered = sorted(bars, key=lambda b: b.position)
    out: dict[str, Value] = {
        f"{axis}_positions": " ".join(f"{b.position - border:.4f}" for b in ordered),
        f"{axis}_widths": " ".join(f"{b.width:.4f}" for b in ordered),
    }
    sigma = np.sqrt(np.mean([b.sigma**2 for b in ordered]))
    if np.isfinite(sigma):
        out[f"sigma_{axis}_positions"] = round(float(sigma), _SIGMA_DIGITS)
    return out
