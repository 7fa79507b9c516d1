"""The options of the solid builder."""

from pydantic import BaseModel, ConfigDict, Field


class BuildOptions(BaseModel):
    """How the reliefs of a facade are cut into a coarse solid."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    depth: bool = Field(
        default=True, description="if false, openings are flush in their wall and protrusions left out"
    )
    bars: bool = Field(
        default=True, description="if false, the frames and bars of windows are counted but not drawn"
    )
    gap: float = Field(
        default=0.02,
        ge=0.005,
        le=0.2,
        description="m: narrowest pier, strip or step; borders closer than this are joined",
    )
    overlaps: str = Field(
        default="clip",
        pattern="^(clip|refuse)$",
        description="what happens to a relief that overlaps an earlier one",
    )
    reseat: bool = Field(
        default=False, description="move the host's walls onto the measured planes instead of keeping them"
    )
    max_offset: float = Field(
        default=1.0,
        gt=0,
        le=10,
        description="m: largest distance between the measured plane and the host wall",
    )
    max_angle: float = Field(
        default=15.0,
        gt=0,
        le=45,
        description="degrees: largest angle between the measured plane and the wall",
    )
    chord_error: float = Field(
        default=0.005,
        ge=0.0005,
        le=0.1,
        description="m: largest distance between a curved outline and its chords",
    )
    block_depth: float = Field(
        default=8.0,
        ge=1,
        le=100,
        description="m: how far a block made from the cloud reaches behind a facade",
    )
