"""The options of orienting photos to one another: few, since most limits follow from the data."""

from pydantic import BaseModel, ConfigDict, Field


class TieOptions(BaseModel):
    """How key points are found and matched, and whether the cameras are known."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    side: int = Field(
        default=3200, ge=400, le=10_000, description="px, longer side to which pictures are reduced"
    )
    most: int = Field(default=8192, ge=500, le=20_000, description="key points of a photo")
    ratio: float = Field(
        default=0.8, gt=0.4, le=1, description="largest distance to the best neighbour, per second best"
    )
    epipolar: float = Field(
        default=1.5, gt=0, le=20, description="px of the full picture, largest distance to an epipolar line"
    )
    least_matches: int = Field(
        default=30, ge=15, le=1000, description="matches that a pair of photos needs at least"
    )
    rival: float = Field(
        default=0.6,
        gt=0,
        le=1,
        description="share of matches that a shift along the wall may explain, before a place is ambiguous",
    )
    self_calibrate: bool = Field(
        default=False, description="estimate focal lengths and distortion too, where cameras are not known"
    )
    blurred: float = Field(
        default=3.0, gt=0.5, le=20, description="px, width of the finest edges above which a photo is blurred"
    )
    seed: int = Field(default=0, ge=0, description="of all random samples")
