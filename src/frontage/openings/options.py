"""The options of opening finding."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class OpeningOptions(BaseModel):
    """What the data cannot tell; cells, thresholds and errors follow from spacing, noise and beam."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    method: Literal["evidence", "paper"] = Field(
        default="evidence",
        description="evidence: beams, layers and an exact layout; paper: edge points, cells, 70 % / 10 %",
    )
    min_width: float = Field(default=0.3, gt=0, description="m: narrower openings are not looked for")
    min_height: float = Field(default=0.3, gt=0, description="m: lower openings are not looked for")
    ground_z: float | None = Field(
        default=None,
        description="m, height of the ground at the wall in the facade frame; None: its outline's foot",
    )
