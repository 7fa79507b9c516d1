"""Houses and openings as a specification describes them; whatever is left out is drawn from the seed."""

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from frontage.model import OpeningKind

FORBID = ConfigDict(extra="forbid", frozen=True)
Shape = Literal["rectangle", "segmental", "round", "pointed", "triangular", "circle"]
Roof = Literal["gable", "street_gable", "hip", "mansard", "flat"]
# least height of each head, as a share of the opening's width
_LEAST_HEIGHT_PER_WIDTH = {
    "rectangle": 0.0,
    "segmental": 1 / 7,
    "round": 0.5,
    "pointed": 0.8661,
    "triangular": 1 / 3,
    "circle": 0.0,
}


class OpeningSpec(BaseModel):
    """One opening of a front: `[[house.opening]]`. x and z are metres from the facade's lower left corner."""

    model_config = FORBID

    kind: OpeningKind = Field(
        default=OpeningKind.WINDOW, description="what it is; doors, passages and garages have an opaque leaf"
    )
    shape: Shape = Field(default="rectangle", description="outline")
    x: float = Field(ge=0, description="m, left edge")
    z: float = Field(description="m, lower edge")
    width: float = Field(gt=0, le=20, description="m")
    height: float = Field(gt=0, le=20, description="m, arch included")
    depth: float = Field(default=0.15, ge=0.02, le=1.0, description="m, reveal: wall to frame or leaf")
    frame: float = Field(default=0.07, ge=0.02, le=0.2, description="m, width of the frame")
    vertical: int = Field(default=0, ge=0, le=4, description="upright bars")
    horizontal: int = Field(default=0, ge=0, le=4, description="transoms")
    bars: Literal["grid", "T", "asymmetric"] = Field(default="grid", description="layout of the bars")
    shutters: Literal["none", "open", "closed"] = Field(
        default="none", description="beside or in the opening"
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.shape == "circle" and abs(self.width - self.height) > 1e-6:
            raise ValueError(f"a circle has one size, but width is {self.width:g} and height {self.height:g}")
        if self.height <= _LEAST_HEIGHT_PER_WIDTH[self.shape] * self.width + 0.02:
            raise ValueError(
                f"height {self.height:g} is too low for a {self.shape} arch {self.width:g} m wide"
            )
        if self.shutters == "closed" and self.depth < 0.05:
            raise ValueError(f"closed shutters need a reveal of 0.05 m, but depth is {self.depth:g}")
        if min(self.width, self.height) <= 2 * self.frame + 0.05:
            raise ValueError(
                f"a frame {self.frame:g} m wide fills an opening of {self.width:g} x {self.height:g} m"
            )
        return self


class HouseSpec(BaseModel):
    """One house of the near side, from left to right: `[[house]]`; whatever is left out is drawn."""

    model_config = FORBID

    width: float | None = Field(default=None, gt=2.5, le=60, description="m along the street")
    depth: float | None = Field(default=None, ge=5, le=40, description="m, front to back")
    floors: int | None = Field(default=None, ge=1, le=12, description="storeys, ground floor included")
    floor_height: float | None = Field(default=None, ge=2.4, le=6, description="m, upper storeys")
    ground_floor_height: float | None = Field(default=None, ge=2.4, le=7, description="m")
    roof: Roof | None = Field(default=None, description="form of the roof")
    wall: Literal["plaster", "brick", "ashlar"] | None = Field(
        default=None, description="material of the walls"
    )
    shape: Shape | None = Field(default=None, description="outline of the upper windows")
    columns: int | None = Field(default=None, ge=1, le=30, description="window axes")
    reveal: float | None = Field(default=None, ge=0.05, le=0.4, description="m, depth of the reveals")
    vertical: int | None = Field(default=None, ge=0, le=4, description="upright bars of the upper windows")
    horizontal: int | None = Field(default=None, ge=0, le=4, description="transoms of the upper windows")
    bars: Literal["grid", "T", "asymmetric"] | None = Field(default=None, description="layout of their bars")
    windows: Literal["regular", "varied"] = Field(
        default="regular", description="varied: divided, coloured and furnished as in real streets"
    )
    shutters: bool | None = Field(default=None, description="window shutters, some open, some closed")
    balconies: bool | None = Field(default=None, description="balconies with railings")
    oriel: bool | None = Field(default=None, description="an oriel over the upper storeys")
    shop: bool | None = Field(default=None, description="shop fronts in the ground floor")
    dormers: bool | None = Field(default=None, description="dormers on the roof")
    lean: float | None = Field(
        default=None, ge=-2, le=2, description="degrees out of plumb, positive: backwards"
    )
    roughness: float | None = Field(
        default=None, ge=0, le=0.02, description="m, one sigma of the wall's surface"
    )
    setback: float | None = Field(default=None, ge=0, le=20, description="m behind the building line")
    gap: float | None = Field(default=None, ge=0, le=40, description="m to the next house; 0 = a party wall")
    twin: bool = Field(default=False, description="built like the house before it; only `gap` is its own")
    opening: tuple[OpeningSpec, ...] = Field(
        default=(), description="the front's openings, instead of drawn ones"
    )

    @model_validator(mode="after")
    def _only_a_twin(self) -> Self:
        others = sorted(self.model_fields_set - {"twin", "gap"})
        if self.twin and others:
            raise ValueError(f"a twin is built like the house before it; leave out {', '.join(others)}")
        return self
