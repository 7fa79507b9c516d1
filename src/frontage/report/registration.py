"""The registration in plan: the model's walls, the scans before and after, the stations with their errors."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.report.data import RegistrationView
from frontage.report.figures import png_uri, to_figure
from frontage.report.plans import Ellipse, error_ellipse, half_axes, magnification, scale_bar

_WIDTH, _HEIGHT = 860.0, 620.0
_AROUND = 10.0  # m about the stations' surroundings that the model covers
_MOTION = {"shift": "shift along", "turn": "turn about"}
_PLACES = ("given", "position")
_SHOWN = 14.0  # px, the longest half-axis of an ellipse comes up to this where it can


@dataclass(frozen=True)
class Station:
    """A station: its name, its place before (px), and the magnified ellipse of its place after."""

    name: str
    x0: float
    y0: float
    error: Ellipse


@dataclass(frozen=True)
class RegistrationFigure:
    """A plan: picture of the points, walls (x1, y1, x2, y2) px, stations, magnification of their ellipses."""

    width: float
    height: float
    href: str
    walls: tuple[tuple[float, ...], ...]
    stations: tuple[Station, ...]
    magnified: int
    bar: float
    bar_label: str


def registration_figure(view: RegistrationView) -> RegistrationFigure:
    """Scans before (light) and after (dark) over the walls of the model (lines), north up."""
    scans = view.record["scans"]
    given, placed = (np.array([s[key] for s in scans])[:, :2] - view.origin[:2] for key in _PLACES)
    low, high = _shown(np.vstack([given, placed]), view.after)
    scale = float(min(_WIDTH / (high[0] - low[0]), _HEIGHT / (high[1] - low[1])))
    size = (high - low) * scale
    pixel = partial(to_figure, origin=np.array([low[0], high[1]]), scale=scale)
    half = [half_axes(np.array(s["covariance"])[:2, :2]) for s in scans]
    magnified = magnification(max(axes[0] for axes in half) * scale, _SHOWN)
    names = [s["scan"] for s in scans]
    ends = pixel(view.walls.reshape(-1, 2)).reshape(-1, 4)
    inside = ((ends > -50) & (ends < size.max() + 50)).all(1)
    bar, bar_label = scale_bar(scale)
    return RegistrationFigure(
        width=float(size[0]),
        height=float(size[1]),
        href=_picture(pixel(view.before), pixel(view.after), size),
        walls=tuple(map(tuple, ends[inside].tolist())),
        stations=_stations(names, pixel(given), pixel(placed), half, scale * magnified),
        magnified=magnified,
        bar=bar,
        bar_label=bar_label,
    )


def _shown(places: Float, points: Float) -> tuple[Float, Float]:
    """Corners (2,) m of what is shown: the instruments and what stands within 60 m of them."""
    near = points[np.linalg.norm(points - places.mean(0), axis=1) < 60.0]
    low, high = np.quantile(np.vstack([places, near]), [0.01, 0.99], axis=0)
    return low - _AROUND, high + _AROUND


def _stations(
    names: list[str], given: Float, placed: Float, half: list[tuple[float, float, float]], scale: float
) -> tuple[Station, ...]:
    """Stations in px; `half` axes in m."""
    return tuple(
        Station(name, float(before[0]), float(before[1]), error_ellipse(after, axes, scale))
        for name, before, after, axes in zip(names, given, placed, half, strict=True)
    )


def registration_rows(record: dict[str, Any]) -> list[dict[str, str]]:
    """One row per scan: how far it moved, standard errors, what the data do not determine."""
    return [_row(scan) for scan in record["scans"]]


def _row(scan: dict[str, Any]) -> dict[str, str]:
    move = np.array(scan["position"]) - np.array(scan["given"])
    sigma = np.sqrt(np.diag(np.array(scan["covariance"])))
    turn = np.array(scan["correction"])[:2, :2]
    names = [_direction(d) for d in scan["observable"] if not d["observable"]]
    return {
        "scan": scan["scan"],
        "moved": f"{np.hypot(move[0], move[1]):.2f} m in plan, {move[2]:+.2f} m up, "
        f"{np.degrees(np.arctan2(turn[1, 0], turn[0, 0])):+.2f}°",
        "sigma": f"{100 * sigma[0]:.1f}, {100 * sigma[1]:.1f}, {100 * sigma[2]:.1f} cm; "
        f"{np.degrees(sigma[5]):.3f}°",
        "lost": "; ".join(names) or "nothing",
        "explained": "–" if scan["explained"] is None else f"{100 * scan['explained']:.0f} %",
    }


def _direction(d: dict[str, Any]) -> str:
    """A direction that is not observable; of a weak one how well the data tell it."""
    name = f"{_MOTION[d['kind']]} ({', '.join(f'{v:.2f}' for v in d['axis'])})"
    sigma = f"{100 * d['sigma']:.1f} cm" if d["kind"] == "shift" else f"{d['sigma']:.3f}°"
    return f"{name}: only to {sigma}" if d.get("weak") else name


def _picture(before: Float, after: Float, size: Float) -> str:
    """Both clouds as a PNG with a transparent ground; after is drawn over before."""
    w, h = int(np.ceil(size[0])), int(np.ceil(size[1]))
    image = np.zeros((h, w, 4), np.uint8)
    for xy, colour in ((before, (90, 130, 235, 150)), (after, (95, 85, 40, 255))):
        inside = np.flatnonzero(((xy >= 0) & (xy < [w, h])).all(1))
        c, r = xy[inside].astype(np.int64).T
        image[r, c] = colour
    return png_uri(image)
