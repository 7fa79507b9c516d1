"""The options for finding window bars."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class CrossbarOptions(BaseModel):
    """Settings that the data cannot tell; the rest follows from pixel size, spacing and noise."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    method: Literal["evidence", "paper", "none"] = Field(
        default="evidence",
        description="evidence: rectified views and an exact layout; paper: matched edges and templates; "
        "none: windows keep no bars",
    )
    min_pane: float = Field(
        default=0.14, gt=0, description="m: least height of a pane; in photos, it may be a quarter narrower"
    )
