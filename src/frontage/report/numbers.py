"""The numbers of a facade as text, each with its standard error."""

import math
from dataclasses import dataclass

import numpy as np

from frontage.model import Facade
from frontage.report.data import FacadeView


@dataclass(frozen=True)
class Fact:
    """One line of a table: what, its value, its standard error or remark."""

    name: str
    value: str
    error: str = ""


def facade_facts(view: FacadeView) -> list[Fact]:
    """Size, plane, lean, heading, roughness, spacing, coverage; then the ortho-image's own numbers."""
    f = view.facade
    x0, z0, x1, z1 = f.extent
    sigma = f.local_from_facade.sigma
    lean, sigma_lean = lean_of(f), float(sigma[3])
    heading = math.degrees(math.atan2(-f.frame.R[0, 1], -f.frame.R[1, 1])) % 360
    facts = [
        Fact("Size", f"{x1 - x0:.2f} × {z1 - z0:.2f} m", "bounding box of the outline"),
        Fact("Plane", f"{len(f.inliers):,} points", f"σ of the offset {_mm(f.sigma_plane)}"),
        Fact("Lean", *_lean(lean, sigma_lean, z1 - z0)),
        Fact("Faces", f"{heading:.3f}° from grid north", f"σ {math.degrees(float(sigma[5])):.4f}°"),
        Fact("Roughness", _mm(f.roughness), "robust σ of the points about the plane"),
        Fact("Bend", _mm(f.curvature[0]), f"sagitta along x, σ {_mm(f.curvature[1])}"),
        Fact("Point spacing", _mm(f.spacing), f"{f.coverage:.0%} of the outline covered"),
        Fact("Layers", ", ".join(f"{1000 * v.y:+.0f}" for v in f.layers) + " mm", "positive = recess"),
        Fact("Street side", f"told by {f.oriented_by}"),
    ]
    if view.ortho is not None:
        w, h = view.ortho.size
        facts.append(Fact("Ortho-image", f"{w} × {h} px", f"GSD {_mm(view.ortho.gsd)}"))
        facts.append(Fact("Sources", _list(view.ortho.sources)))
    origin = ", ".join(f"{v:.3f}" for v in f.world.to_world(f.frame.t))
    facts.append(Fact("Frame origin", origin, "world, m"))
    return facts


def lean_of(facade: Facade) -> float:
    """Lean of the wall in rad, from its normal; positive = its top leans to the street."""
    return math.asin(float(np.clip(facade.frame.R[2, 1], -1, 1)))


def _lean(lean: float, sigma: float, height: float) -> tuple[str, str]:
    """The angle and what it makes over the height; its sigma and t-value (|t| > 3: the wall does lean)."""
    value = f"{math.degrees(lean):+.4f}° ({1000 * height * math.tan(lean):+.0f} mm over {height:.1f} m)"
    if not (math.isfinite(sigma) and sigma > 0):
        return value, "σ not known"
    side = (
        "no significant lean"
        if abs(lean) < 3 * sigma
        else ("to the street" if lean > 0 else "from the street")
    )
    return value, f"σ {math.degrees(sigma):.4f}°, t = {lean / sigma:+.1f}: {side}"


def _mm(metres: float) -> str:
    """A length in mm with three significant digits or so."""
    if not math.isfinite(metres):
        return "not known"
    mm = 1000 * metres
    return f"{mm:.2f} mm" if abs(mm) < 10 else f"{mm:.0f} mm"


def _list(names: tuple[str, ...], most: int = 8) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
