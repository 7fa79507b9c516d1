"""The tolerances of a validation."""

from pydantic import BaseModel, ConfigDict, Field


class Tolerances(BaseModel):
    """How close counts as the same, and how flat as flat; the defaults are val3dity's."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    snap: float = Field(
        default=0.001,
        ge=0,
        lt=1e3,
        allow_inf_nan=False,
        description="vertices this close (m) are one",
    )
    planarity_distance: float = Field(
        default=0.01,
        gt=0,
        lt=1e6,
        allow_inf_nan=False,
        description="distance of a vertex to the plane (m)",
    )
    planarity_normals: float = Field(
        default=20.0, gt=0, le=180, description="angle between the normals of a face's triangles (degrees)"
    )
    overlap: float = Field(
        default=-1.0,
        ge=-1,
        lt=1e6,
        allow_inf_nan=False,
        description="overlap or gap between solids that is still accepted (m); -1 = none",
    )
