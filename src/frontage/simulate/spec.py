"""What a simulated street is asked to be."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

FORBID = ConfigDict(extra="forbid", frozen=True)


class SceneSpec(BaseModel):
    """A street; what is left out (None) is drawn from the seed."""

    model_config = FORBID

    name: str = Field("street", description="name of the scene")
    seed: int = Field(0, ge=0, description="seed of everything that is drawn")
    houses: int = Field(4, ge=0, le=500, description="houses on the near side of the street")
    setting: Literal["terrace", "detached"] | None = Field(None, description="terrace or detached houses")
    slope: float | None = Field(None, ge=-12, le=12, description="rise along the street, percent")
    street_width: float | None = Field(None, ge=6, le=60, description="facade to facade, m")
    opposite: bool = Field(True, description="houses on the other side")
    crs: str | None = Field("EPSG:25832", description="projected metric CRS of the scene")
    origin: tuple[int, int, int] = Field((691_000, 5_336_000, 500), description="world origin, m")
