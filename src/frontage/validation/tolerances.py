"""The tolerances of the validator."""

from pydantic import BaseModel, ConfigDict, Field


class Tolerances(BaseModel):
    """How close vertices must be to count as one, and how flat a face must be; defaults as in val3dity."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    snap: float = Field(
        default=0.001,
        ge=0,
        lt=1e3,
        allow_inf_nan=False,
        description="vertices closer than this (m) are one",
    )
    planarity_distance: float = Field(
        default=0.01,
        gt=0,
        lt=1e6,
        allow_inf_nan=False,
        description="largest distance of a vertex from the plane of its face (m)",
    )
    planarity_normals: float = Field(
        default=20.0,
        gt=0,
        le=180,
        description="largest angle between the normals of a face's triangles (degrees)",
    )
    overlap: float = Field(
        default=-1.0,
        ge=-1,
        lt=1e6,
        allow_inf_nan=False,
        description="largest overlap or gap between solids that is accepted (m); -1 = none",
    )
