"""What is cut into a wall or put before it, the options, and what comes out."""

from dataclasses import dataclass, field

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Failed, Solid

GRID = 10_000  # vertices per metre: solids lie on a grid of 0.1 mm


@dataclass(frozen=True, eq=False)
class Relief:
    """A part of a facade that is another surface, or lies deeper or further out, than what is around it.

    ring       (k, 2) m (x, z) in the facade frame
    depth      m behind the surface around it, negative = a protrusion; None = flush, a face of its own
    semantics  class of its surface: "Window", "Door", "WallSurface" for a protrusion or a niche
    inside     reliefs on its own surface, their depth counted from there
    """

    id: str
    ring: Float
    depth: float | None
    semantics: str = "Window"
    inside: tuple["Relief", ...] = ()

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class FacadeReliefs:
    """A facade as the solid needs it: id, measured frame, outline (k, 2) m (x, z), what is on it.

    Earlier reliefs win where two overlap.
    """

    id: str
    local_from_facade: Rigid3
    outline: Float
    reliefs: tuple[Relief, ...]

    def __post_init__(self) -> None:
        freeze(self, outline=((None, 2), np.float64))


class BuildOptions(BaseModel):
    """How reliefs go into a host solid."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    depth: bool = Field(default=True, description="false: every opening flush in its wall, no protrusions")
    gap: float = Field(
        default=0.02,
        ge=0.005,
        le=0.2,
        description="m: the narrowest pier, strip or step; closer borders are joined",
    )
    overlaps: str = Field(
        default="clip", pattern="^(clip|refuse)$", description="a relief that overlaps an earlier one"
    )
    reseat: bool = Field(
        default=False, description="move the host's walls onto the measured planes; false: keep its vertices"
    )
    max_offset: float = Field(
        default=1.0, gt=0, le=10, description="m between the measured plane and the host wall, at most"
    )
    max_angle: float = Field(
        default=15.0, gt=0, le=45, description="degrees between the measured plane and the host wall, at most"
    )
    chord_error: float = Field(
        default=0.005,
        ge=0.0005,
        le=0.1,
        description="m: curved outlines keep vertices so that chords stay as near",
    )
    block_depth: float = Field(
        default=8.0,
        ge=1,
        le=100,
        description="m: how deep a block made from the cloud reaches behind a facade",
    )


@dataclass(frozen=True, eq=False)
class Built:
    """A solid with its reliefs.

    solid     the finer solid; `host` itself where nothing could be cut
    host      the coarse solid (after re-seating, if asked for): level of detail 2 is got back from here
    offsets   relief id -> m from its measured plane to the wall that it was put in, positive = the wall lies
              further into the building; the mean over its corners
    failed    reliefs that are not in the solid, and why
    notes     what was changed on the way
    """

    solid: Solid
    host: Solid
    offsets: dict[str, float] = field(default_factory=dict)
    failed: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()
