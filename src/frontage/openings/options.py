"""The options for finding openings."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class OpeningOptions(BaseModel):
    """Settings that the data cannot tell; the rest follows from spacing, noise and beam width."""

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
