"""The specification of a simulated street, and how it is read from TOML."""

import tomllib
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from frontage.errors import OptionError
from frontage.simulate.houses.housespec import HouseSpec
from frontage.simulate.output import OutputSpec
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import DriveSpec, ScannerSpec
from frontage.simulate.survey import ModelSpec

# keys that describe drawn houses and ground, which a city model replaces
_DRAWN = frozenset(
    ("houses", "house", "setting", "slope", "street_width", "opposite", "hedges", "crs", "origin")
)


class SceneSpec(BaseModel):
    """A street and the sensors that record it; whatever is left out is drawn from the seed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(default="street", min_length=1, description="name of the scene")
    seed: int = Field(default=0, ge=0, description="seed of everything that is drawn")
    from_model: tuple[str, ...] = Field(
        default=(), description="city models (CityGML, CityJSON) to build instead of drawn houses"
    )
    houses: int | None = Field(
        default=None, ge=0, le=500, description="houses on each side; None: those of `house`, or else 4"
    )
    setting: Literal["terrace", "detached"] | None = Field(
        default=None, description="terrace or detached houses"
    )
    slope: float | None = Field(default=None, ge=-12, le=12, description="rise along the street, percent")
    street_width: float | None = Field(
        default=None, ge=6, le=60, description="building line to building line, m"
    )
    opposite: bool = Field(default=True, description="houses on the other side")
    trees: int | None = Field(default=None, ge=0, le=500, description="trees along the pavements")
    cars: int | None = Field(default=None, ge=0, le=500, description="parked cars")
    lamps: int | None = Field(default=None, ge=0, le=500, description="street lamps")
    people: int | None = Field(default=None, ge=0, le=500, description="pedestrians")
    hedges: bool | None = Field(default=None, description="hedges before houses that stand back")
    crs: str | None = Field(default="EPSG:25832", description="projected metric CRS of the scene")
    origin: tuple[int, int, int] = Field(
        default=(691_000, 5_336_000, 500), description="world origin of local coordinates, m"
    )
    house: tuple[HouseSpec, ...] = Field(
        default=(), description="houses of the near side, from s = 0 on; missing ones are drawn"
    )
    scanners: tuple[ScannerSpec, ...] = Field(default=(), description="terrestrial scanners")
    drive: DriveSpec | None = Field(default=None, description="a mobile recording")
    cameras: tuple[CameraSpec, ...] = Field(default=(), description="series of photographs")
    model: ModelSpec = Field(default_factory=ModelSpec, description="errors of the LoD2 city model")
    output: OutputSpec = Field(default_factory=OutputSpec, description="formats and sizes of the files")

    @field_validator("from_model", mode="before")
    @classmethod
    def _accept_single_path(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _check_model_keys(self) -> Self:
        if self.from_model and (stated := sorted(self.model_fields_set & _DRAWN)):
            raise ValueError(f"from_model brings its own houses and ground; leave out {', '.join(stated)}")
        return self

    @model_validator(mode="after")
    def _check_first_house(self) -> Self:
        if self.house and self.house[0].twin:
            raise ValueError("house 1 is a twin of the house before it, but there is none; leave out twin")
        return self


def parse_spec(text: str, name: str = "spec") -> SceneSpec:
    """Read a specification from TOML text; `name`, usually that of its file, starts every error message.

    Raises OptionError with one sentence for text that is not TOML, an unknown key or a value out of range.
    """
    try:
        return SceneSpec.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise OptionError(f"{name}: not TOML ({error}); quote texts and write tables as [[house]]") from None
    except ValidationError as error:
        raise OptionError(f"{name}: {_explain(error)}") from None


def _explain(error: ValidationError) -> str:
    """Says in one sentence what is wrong first, and what would be right."""
    found = error.errors()
    first = next((e for e in found if e["type"] == "extra_forbidden"), found[0])  # a typo causes other errors
    where = _location(first["loc"])
    message = str(first["msg"]).removeprefix("Value error, ")
    if first["type"] == "extra_forbidden":
        return f"unknown key {where}; known there: {', '.join(_known_keys(first['loc']))}"
    if first["type"] == "value_error":
        return f"{where}: {message}" if where else message
    if first["type"] == "missing":
        return f"{where} is missing; add it"
    if first["type"] == "tuple_type" and isinstance(first["input"], dict):
        return f"{where} must be a list of tables; write [[{_table_name(first['loc'])}]] in two brackets"
    if first["type"] == "model_type":
        return f"{where} must be a table, not {first['input']!r}"
    return f"{where} = {first['input']!r} is not usable: {message[:1].lower()}{message[1:]}"


def _location(location: tuple[int | str, ...]) -> str:
    """Returns the place in the file, such as "house 2, opening 3, width"; tables are counted from 1."""
    words: list[str] = []
    for part in location:
        if isinstance(part, int):
            words[-1] += f" {part + 1}"
        else:
            words.append(part)
    return ", ".join(words)


def _table_name(location: tuple[int | str, ...]) -> str:
    """Returns the name of a table in TOML, such as "house.opening"."""
    return ".".join(part for part in location if isinstance(part, str))


def _known_keys(location: tuple[int | str, ...]) -> list[str]:
    """Returns the keys that are allowed where an unknown one was found."""
    fields: Any = SceneSpec
    for part in location[:-1]:
        if isinstance(part, str):
            fields = _model_class(fields.model_fields[part].annotation)
    return sorted(fields.model_fields)


def _model_class(annotation: Any) -> Any:
    """Returns the model class inside ``tuple[Model, ...]`` or ``Model | None``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        found = _model_class(argument)
        if found is not None:
            return found
    return None
