"""What a simulated street is asked to be."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from frontage.simulate.housespec import HouseSpec

FORBID = ConfigDict(extra="forbid", frozen=True)


class SceneSpec(BaseModel):
    """A street; what is left out (None) is drawn from the seed."""

    model_config = FORBID

    name: str = Field(default="street", description="name of the scene")
    seed: int = Field(default=0, ge=0, description="seed of everything that is drawn")
    houses: int = Field(default=4, ge=0, le=500, description="houses on each side of the street")
    setting: Literal["terrace", "detached"] | None = Field(
        default=None, description="terrace or detached houses"
    )
    slope: float | None = Field(default=None, ge=-12, le=12, description="rise along the street, percent")
    street_width: float | None = Field(default=None, ge=6, le=60, description="facade to facade, m")
    opposite: bool = Field(default=True, description="houses on the other side")
    crs: str | None = Field(default="EPSG:25832", description="projected metric CRS of the scene")
    origin: tuple[int, int, int] = Field(default=(691_000, 5_336_000, 500), description="world origin, m")
    house: tuple[HouseSpec, ...] = Field(default=(), description="houses of the near side, from s = 0 on")
