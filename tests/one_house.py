"""Streets of one wide house whose front is not flat: what must not be cut.

Made of three pieces in one style, side by side; the middle stands out, is set back, is higher, has an oriel.
"""

from dataclasses import replace
from typing import Literal
from unittest.mock import patch

import numpy as np

import scenes
from frontage.geometry.rigid import Rigid3
from scene_parts import Box, HouseTruth, build_house, draw_style

Kind = Literal["plain", "risalit", "attic", "recess", "oriel"]
KINDS: tuple[Kind, ...] = ("plain", "risalit", "attic", "recess", "oriel")
_OFFSET = {"risalit": -0.5, "attic": -0.5, "recess": 0.4}  # m, towards the street is negative


def one_house(kind: Kind, seed: int, spacing: float = 0.07, slope: float = 0.0) -> scenes.Scene:
    """A house 28 m wide with wings of 10 m beside a middle of 8 m: `risalit` stands out by 0.5 m, `attic` is
    a storey higher besides, `recess` is set back by 0.4 m, `oriel` hangs above the ground floor."""

    def row(
        rng: np.random.Generator, count: int, both_sides: bool, twins: bool, rise: float, frame: Rigid3
    ) -> tuple[HouseTruth, ...]:
        wing = replace(draw_style(rng, int(rng.integers(5))), width=10.0, offset=0.0, balcony=False)
        middle = replace(wing, width=8.0, offset=_OFFSET.get(kind, 0.0))
        if kind == "attic":
            middle = replace(middle, floors=wing.floors + 1)
        pieces, s = [], 0.0
        for i, style in enumerate((wing, middle, wing)):
            pieces.append(build_house(i, 0, s, style, 0.0, frame, int(rng.integers(1 << 30))))
            s += style.width
        if kind == "oriel":
            body = Box((2.4, -0.9, wing.ground_height), (5.6, 0.0, pieces[1].height - 1.2), "oriel")
            pieces[1] = replace(pieces[1], boxes=(*pieces[1].boxes, body))
        return tuple(pieces)

    with patch.object(scenes, "build_houses", row):
        return scenes.street_scene(seed=seed, spacing=spacing, slope=slope)
