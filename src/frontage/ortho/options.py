"""The options of an ortho-image."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class OrthoOptions(BaseModel):
    """Options of `make_ortho`; lengths in metres."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    gsd: float = Field(default=0.01, gt=0, le=1.0, description="metre per pixel of the ortho-image")
    margin: float = Field(default=0.2, ge=0, le=20.0, description="metres added around the facade's outline")
    relief: bool = Field(
        default=True,
        description="place every pixel on the measured relief (true ortho-image) instead of the plane",
    )
    front: float = Field(
        default=1.5, ge=0, le=10.0, description="metres in front of the plane that still belong to the facade"
    )
    back: float = Field(
        default=1.5, ge=0, le=10.0, description="metres behind the plane that still belong to the facade"
    )
    projection: Literal["full", "homography"] = Field(
        default="full",
        description="full: lens distortion and relief; homography: paper A's map of the plane, neither",
    )
    interpolation: Literal["adaptive", "bilinear", "nearest"] = Field(
        default="adaptive",
        description="adaptive: cubic, prefiltered where the photo is finer; bilinear: paper A's",
    )
    radiometry: Literal["balanced", "as shot"] = Field(
        default="balanced",
        description="balanced: photos in one light, seams blended; as shot: every pixel as in its photo",
    )
    fill: Literal["nothing", "symmetry"] = Field(
        default="nothing",
        description="what nothing saw stays empty, or is filled by symmetry and marked as inferred",
    )
    max_photos: int = Field(
        default=24,
        ge=1,
        le=1000,
        description="at most this many photos, those that show most of the facade best",
    )

    @property
    def draws_relief(self) -> bool:
        """Whether pixels are placed on the relief; the homography knows only the plane."""
        return self.relief and self.projection == "full"
