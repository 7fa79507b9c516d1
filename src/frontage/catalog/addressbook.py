"""Which building stands at which address: told by the city model and by the project file.

The project file names a building by its id, or by a place, which stays true if buildings are numbered anew::

    [addresses]                        [[addresses]]
    B07 = "13 rue Soufflot"            address = "13 rue Soufflot"
                                       at = [651602.1, 6860834.5]   # or: building = "B07"
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Self

import numpy as np
import shapely
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from frontage.catalog.addresses import find_building
from frontage.errors import InputError

_REACH_M = 15.0  # a point given for a house lies on it or in front of its door


class AddressEntry(BaseModel):
    """The address of one building, which is named by its id or by a point on it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    address: str = Field(min_length=1, description='as people say it, "13 rue Soufflot"')
    building: str | None = Field(default=None, min_length=1, description='the building\'s id, "B07"')
    at: tuple[float, float] | None = Field(
        default=None, description="m, x and y in the run's CRS: on the building or before it"
    )

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.building is None) == (self.at is None):
            raise ValueError(f'"{self.address}" needs either building = "B07" or at = [x, y]')
        if self.at is not None and not np.isfinite(self.at).all():
            raise ValueError(f'"{self.address}": at needs two finite numbers')
        return self


def _as_entries(value: Any) -> Any:
    """Expand the short form, a table of id = address or list of addresses, to entries."""
    if not isinstance(value, Mapping):
        return value
    pairs = [(b, a) for b, told in value.items() for a in (told if isinstance(told, list) else [told])]
    if not all(isinstance(a, str) for _, a in pairs):
        raise ValueError('write B07 = "13 rue Soufflot", or [[addresses]] with address and at or building')
    return [{"building": b, "address": a} for b, a in pairs]


def _once(entries: tuple[AddressEntry, ...]) -> tuple[AddressEntry, ...]:
    told: dict[str, AddressEntry] = {}
    for entry in entries:
        if told.setdefault(entry.address.casefold(), entry) != entry:
            raise ValueError(f'"{entry.address}" is given to two places; give each its own address')
    return entries


AddressBook = Annotated[tuple[AddressEntry, ...], BeforeValidator(_as_entries), AfterValidator(_once)]
"""The addresses of a project file, in either form."""


def building_at(asked: str, known: Mapping[str, Sequence[str]], lost: Mapping[str, str]) -> str:
    """Return the id of the building that `asked`, an id or an address, means.

    known, lost: what `known_addresses` returns.

    Raises InputError with one sentence: none, several, or an address that belongs to no building.
    """
    try:
        return find_building(asked, {building: list(own) for building, own in known.items()})
    except InputError:
        meant = _meant(asked, list(lost))
        if meant is None:
            raise
        raise InputError(lost[meant]) from None


def known_addresses(
    mapped: Mapping[str, str | None], plans: Mapping[str, shapely.Geometry], book: Sequence[AddressEntry]
) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Return every building's addresses, the city model's first, and why an address of the book is nobody's.

    mapped  the address that the city model gives to every building of the run
    plans   the ground plan of every building in world coordinates; needed for entries with `at`
    """
    known = {building: [address] if address else [] for building, address in mapped.items()}
    lost: dict[str, str] = {}
    for entry in book:
        building, why = _placed(entry, plans, list(known))
        if why:
            lost[entry.address] = why
        elif entry.address not in known[building]:
            known[building].append(entry.address)
    return known, lost


def _meant(asked: str, addresses: list[str]) -> str | None:
    try:
        return find_building(asked, {address: [address] for address in addresses})
    except InputError:
        return None


def _placed(entry: AddressEntry, plans: Mapping[str, shapely.Geometry], known: list[str]) -> tuple[str, str]:
    """Return the building of an entry, or why there is none."""
    if entry.at is None:
        building = str(entry.building)
        there = ", ".join(known) or "none"
        why = f'the project file gives "{entry.address}" to building "{building}", but the run has {there}'
        return building, "" if building in known else why
    point = shapely.Point(entry.at)
    distance = {building: float(shapely.distance(plan, point)) for building, plan in plans.items()}
    building = min(distance, key=lambda b: distance[b], default="")
    if building and distance[building] <= _REACH_M:
        return building, ""
    near = f"; the nearest, {building}, is {distance[building]:.0f} m away" if building else ""
    x, y = entry.at
    return "", f'the project file puts "{entry.address}" at {x:g}, {y:g}, where no building stands{near}'
