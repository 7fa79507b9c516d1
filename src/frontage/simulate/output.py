"""File formats and sizes of a simulated scene."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class OutputSpec(BaseModel):
    """Formats and sizes of the files: `[output]`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    scans: Literal["e57", "ptx", "laz"] = Field(
        default="e57", description="format of the terrestrial scans; a mobile recording is LAZ"
    )
    gsd: float = Field(
        default=0.01, ge=0.001, le=0.1, description="m per pixel of the true ortho-images and of project.toml"
    )
    quality: int = Field(default=90, ge=30, le=100, description="of the JPEG files")
