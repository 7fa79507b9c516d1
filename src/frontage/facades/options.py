"""The options of facade finding."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class FacadeOptions(BaseModel):
    """What the data cannot tell; thresholds that follow from the data (noise, spacing) are measured."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    method: Literal["lo-msac", "paper"] = Field(
        default="lo-msac",
        description="lo-msac: vertical, refined, every facade; paper: 3-point RANSAC, the main plane only",
    )
    levelled: bool = Field(
        default=True,
        description="the cloud's z axis is the plumb line (to a degree); false: planes from three points",
    )
    min_area: float = Field(
        default=5.0,
        gt=0,
        description="m2 of seen wall that a facade needs: a storey high (2.5 m), a bay wide (2 m)",
    )
    min_share: float = Field(
        default=0.05,
        ge=0,
        le=1,
        description="seen wall that a facade needs, as a share of the building's largest",
    )
    max_facades: int = Field(default=32, ge=1, le=200, description="facades of one building, at most")
    depth_front: float = Field(
        default=1.5,
        gt=0,
        description="m in front of the plane that belong to the facade: balconies, oriels, cornices",
    )
    depth_back: float = Field(
        default=1.0,
        gt=0,
        description="m behind the plane that belong to the facade: reveals, recesses, loggias",
    )
    max_lean: float = Field(
        default=10.0, gt=0, lt=60, description="degrees a wall may lean; 3-point samples obey it too"
    )
    lean_sigma: float = Field(
        default=0.5, gt=0, description="degrees: one sigma of the prior on a wall's lean"
    )
    paper_threshold: float = Field(default=0.05, gt=0, description="m: inlier distance of the method 'paper'")
    paper_iterations: int = Field(default=500, ge=1, description="samples of the method 'paper'")
