"""What a run has measured, gathered for tables and drawings."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth, ring_area, ring_area_sigma
from frontage.model import Elements, Facade, Opening, Photo, WorldRef
from frontage.model.opening import DOORS

Front = tuple[Facade, Elements | None]
"""A facade and what was found on it; None = its openings were not looked for, or that failed."""


@dataclass(frozen=True, eq=False)
class SurveyedBuilding:
    """A building of a run.

    ground   m, height of the ground at its foot in the world; None = not known
    plan     (k, 2) m world: its footprint, or the hull of its points; None = neither is known
    source   where the plan comes from: "footprint", "hull of its points" or ""
    missing  why it has no facade, or what could not be made for it
    """

    id: str
    address: str | None
    ground: float | None
    plan: Float | None
    source: str
    fronts: tuple[Front, ...]
    missing: tuple[str, ...] = ()

    @property
    def openings(self) -> Iterator[tuple[Facade, Elements, Opening]]:
        """Every opening with its facade and what else is on that."""
        for facade, elements in self.fronts:
            for opening in () if elements is None else elements.openings:
                assert elements is not None
                yield facade, elements, opening


@dataclass(frozen=True, eq=False)
class Survey:
    """What a run has measured.

    photos    oriented ones; those without a pose are named in `left_out`
    stations  (s, 3) m world: where the scanner stood, or was
    left_out  what tables and drawings cannot show, and why, one sentence each
    """

    world: WorldRef
    buildings: tuple[SurveyedBuilding, ...]
    photos: tuple[Photo, ...]
    stations: Float
    left_out: tuple[str, ...]


def heights(facade: Facade, ring: Float, y: float = 0.0) -> Float:
    """Return the heights (k,) m above the datum of the world of corners (k, 2) m at depth y m of a facade."""
    return in_world(facade, ring, y)[:, 2]


def in_world(facade: Facade, ring: Float, y: float = 0.0) -> Float:
    """Return corners (k, 2) m at depth y m of a facade in the world (k, 3)."""
    return np.asarray(facade.world.to_world(facade.frame.apply(at_depth(ring, y))), np.float64)


def window_to_wall(fronts: tuple[Front, ...]) -> tuple[float | None, float | None]:
    """Return the window-to-wall ratio of facades and its standard error; None if nothing was looked for.

    It is the area of all openings but doors, gates and passages divided by the area of the outlines. The
    openings' areas are taken as independent; the outlines are taken as exact.
    """
    glass = variance = wall = 0.0
    for facade, elements in fronts:
        if elements is None:
            continue
        wall += abs(ring_area(facade.outline))
        for o in elements.openings:
            if o.kind not in DOORS:
                glass += abs(ring_area(o.ring))
                variance += ring_area_sigma(o.ring, o.ring_covariance) ** 2
    return (glass / wall, variance**0.5 / wall) if wall > 0 else (None, None)
