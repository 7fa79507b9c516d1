"""The options of the building split."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class BuildingOptions(BaseModel):
    """How a street is divided into buildings. The defaults come from how houses are built."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    method: Literal["frontage", "paper"] = Field(
        default="frontage",
        description="'paper' = octree cells + connected components only (paper A, section 2.1)",
    )
    cell: float | None = Field(
        default=None,
        gt=0,
        le=10,
        description="m, octree cell of the components; default max(0.25, 3 x measured spacing)",
    )
    min_width: float = Field(default=3.5, ge=1, le=50, description="m, the narrowest house along the street")
    min_wall_height: float = Field(
        default=3.0, ge=0.5, le=50, description="m, how high a wall must rise to count as one"
    )
    ground_slope: float = Field(default=0.15, ge=0, le=1, description="steepest ground, rise over run")
    ground_tolerance: float = Field(
        default=0.15, gt=0, le=1, description="m, thickness of the ground: kerbs are ground"
    )
    max_depth: float = Field(
        default=20.0, gt=0, le=200, description="m, how far behind its front a building may reach"
    )
    snap: float = Field(
        default=1.0, ge=0, le=5, description="m, how far a footprint may pull a cut to its party wall"
    )
    split: bool = Field(
        default=True, description="cut terraces into houses; False = one building per connected street front"
    )
