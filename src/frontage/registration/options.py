"""The options of registration: only what the data cannot tell."""

from pydantic import BaseModel, ConfigDict, Field


class RegistrationOptions(BaseModel):
    """How good the city model is, and how large the surfels are that scans are cut into."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    sigma_model: float = Field(
        default=0.05,
        ge=0,
        le=5,
        description="m, one sigma per axis of a building's position in the plan of the model",
    )
    sigma_height: float = Field(
        default=0.15, ge=0, le=10, description="m, one sigma of a building's base and roof in the model"
    )
    sigma_lean: float = Field(
        default=0.3,
        ge=0,
        le=10,
        description="degrees, one sigma of the lean of walls that the model shows upright",
    )
    cell: float = Field(
        default=0.2,
        ge=0.05,
        le=2,
        description="m, cubes whose points become one surfel; up to four times as wide in sparse parts",
    )
    reach: float = Field(
        default=70.0,
        ge=10,
        le=500,
        description="m, range up to which points are used; others say little",
    )
    observable: float = Field(
        default=0.10,
        gt=0,
        le=5,
        description="m, the largest sigma of an observable direction, however poor the model is",
    )
