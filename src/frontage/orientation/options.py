"""The options of orienting photos."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

Source = Literal["auto", "intensity", "colour", "geometry"]


class OrientationOptions(BaseModel):
    """How photos are oriented against each other and against the scan."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    source: Source = Field(
        default="auto",
        description="what of the scan photos are compared with; auto: what tells most about them",
    )
    calibration: Literal["auto", "fixed", "estimated"] = Field(
        default="auto",
        description="focal length, principal point and distortion; auto: fixed when they are given, "
        "estimated when they come from EXIF",
    )
    key_points: int = Field(default=8192, ge=500, le=20_000, description="key points of a photo")
    picture_side: int = Field(
        default=3200,
        ge=400,
        le=10_000,
        description="px, longer side of the pictures that key points are found in",
    )
