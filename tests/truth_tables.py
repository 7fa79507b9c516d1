"""A truth.json written by hand for two terraced houses, and right and wrong results made from it."""

from dataclasses import replace
from typing import Any

import numpy as np

from frontage.evaluation.result import FoundBar, FoundFacade, FoundOpening
from frontage.evaluation.truth import TrueFacade, TrueOpening, Truth, read_truth
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3

ORIGIN = [691_000, 5_336_000, 500]
TURN = 0.6  # rad, of the street
WIDTH, HEIGHT = 8.0, 9.0


def axes() -> Float:
    c, s = np.cos(TURN), np.sin(TURN)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def opening(name: str, x: float, z: float, visible: float = 1.0, **more: Any) -> dict[str, Any]:
    bars = {"vertical": [{"position": x + 0.5, "extent": [z + 0.1, z + 1.4], "width": 0.05}],
            "horizontal": [{"position": z + 1.0, "extent": [x + 0.1, x + 0.9], "width": 0.05}]}  # fmt: skip
    return {
        "id": name, "kind": "window", "shape": "rectangle", "wall_y": 0.0, "depth": 0.15, "glass_depth": 0.2,
        "outline": [[x, z], [x + 1, z], [x + 1, z + 1.5], [x, z + 1.5]], "frame_width": 0.07, "bars": bars,
        "shutters": "none", "glazed": True, "floor": 0, "bay": 1,
        "visible": {"stations": visible, "any": visible},
    } | more  # fmt: skip


def table() -> dict[str, Any]:
    """Returns the truth of houses B01 and B02, which stand wall to wall and have six windows each; the last
    window of B01 is hidden, that of B02 has closed shutters."""
    R = axes()
    buildings, facades = [], []
    for k in range(2):
        name = f"B{k + 1:02d}"
        origin = R @ np.array([k * WIDTH, 0.0, 0.0]) + ORIGIN
        corners = np.array([[0, 0], [WIDTH, 0], [WIDTH, 10], [0, 10]]) + np.array([k * WIDTH, 0])
        buildings.append({
            "id": name, "address": f"{2 * k + 1} Lime Street", "side": 0, "facades": [f"{name}/F1"],
            "footprint": (corners @ R[:2, :2].T + ORIGIN[:2]).tolist(),
        })  # fmt: skip
        windows = [
            opening(f"{name}/F1/W{f}-{b}", 1.0 + 2.2 * b, 1.0 + 3.5 * f) for f in (0, 1) for b in range(3)
        ]
        facades.append({
            "id": f"{name}/F1", "building": name, "visible": {"stations": 1.0, "any": 1.0}, "ortho": None,
            "frame": {"origin": origin.tolist(), "x": R[:, 0].tolist(), "y": R[:, 1].tolist(),
                      "z": R[:, 2].tolist()},
            "outline": [[0, 0], [WIDTH, 0], [WIDTH, HEIGHT], [0, HEIGHT]],
            "openings": windows, "protrusions": [],
        })  # fmt: skip
    facades[0]["openings"][5]["visible"] = {"stations": 0.05, "any": 0.05}
    facades[1]["openings"][5]["shutters"] = "closed"
    pose = {"R": np.eye(3).tolist(), "center": ORIGIN, "position": ORIGIN}
    return {
        "schema": 1, "name": "two houses", "crs": "EPSG:25832", "origin": ORIGIN, "buildings": buildings,
        "facades": facades, "photos": [{"name": "a.jpg", "true": pose, "given": pose}],
        "stations": [{"file": "scans/s.e57", "number": 1, "true": pose, "given": pose}], "points": [],
    }  # fmt: skip


def truth() -> Truth:
    return read_truth(table())


def found_opening(facade: TrueFacade, o: TrueOpening, move: Float | None = None, **more: Any) -> FoundOpening:
    """Returns what a perfect detector finds; `move` (4,) m shifts left, right, bottom and top."""
    (x0, z0), (x1, z1) = o.ring.min(0), o.ring.max(0)
    x0, x1, z0, z1 = np.array([x0, x1, z0, z1]) + (0 if move is None else move)
    ring = facade.frame.apply(np.array([[x0, 0, z0], [x1, 0, z0], [x1, 0, z1], [x0, 0, z1]]))
    bars = []
    for b in o.bars:
        across, along = np.full(2, b.position), np.array(b.extent)
        x, z = (across, along) if b.axis == "vertical" else (along, across)
        bars.append(FoundBar(b.axis, facade.frame.apply(np.column_stack([x, np.full(2, o.depth), z]))))
    plain = FoundOpening(o.id, o.kind, ring, o.depth, o.shape, tuple(bars))
    return replace(plain, **more)


def found_openings(t: Truth, **more: Any) -> list[FoundOpening]:
    return [found_opening(f, o, **more) for f in t.facades for o in f.openings]


def found_facade(
    f: TrueFacade, offset: float = 0.0, turn: float = 0.0, covariance: Float | None = None
) -> FoundFacade:
    """Returns the true facade, moved inwards by `offset` m and turned about its vertical by `turn` rad."""
    c, s = np.cos(turn), np.sin(turn)
    middle = f.outline.mean(0)
    at = f.frame.apply(np.array([[middle[0], offset, middle[1]]]))[0]
    R = f.frame.R @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return FoundFacade(f.id, f.building, Rigid3("local", "facade", R, at), f.outline - middle, covariance)
