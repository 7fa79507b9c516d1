"""Which building stands at which address: from the city model, and from the project file.

In the project file either by id, or by a place that stays true when buildings are numbered anew::

    [addresses]                        [[addresses]]
    B07 = "13 rue Soufflot"            address = "13 rue Soufflot"
                                       at = [651602.1, 6860834.5]   # or: building = "B07"
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
import shapely
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from frontage.catalog import find_building
from frontage.errors import InputError

if TYPE_CHECKING:
    from frontage.pipeline.workspace import Workspace

_REACH = 15.0  # m: a point given for a house lies on it or before its door


class AddressEntry(BaseModel):
    """The address of one building, told by its id or by a point on it."""

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
    """The short form, a table of id = address or list of addresses, as entries."""
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


def building_at(workspace: "Workspace", asked: str, book: Sequence[AddressEntry]) -> str:
    """The id of the building that `asked`, an id or an address, means.

    Raises InputError with one sentence: none, several, or an address given to no building.
    """
    known, lost = known_addresses(workspace, book)
    try:
        return find_building(asked, known)
    except InputError:
        meant = _meant(asked, list(lost))
        if meant is None:
            raise
        raise InputError(lost[meant]) from None


def known_addresses(
    workspace: "Workspace", book: Sequence[AddressEntry]
) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Every building's addresses, the city model's first; why an address of the book is nobody's."""
    records = workspace.building_records()
    known = {str(r["id"]): [str(r["address"])] if r["address"] else [] for r in records}
    plans = _plans(workspace, records) if any(entry.at for entry in book) else {}
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
    """The building of an entry, or why there is none."""
    if entry.at is None:
        building = str(entry.building)
        there = ", ".join(known) or "none"
        why = f'the project file gives "{entry.address}" to building "{building}", but the run has {there}'
        return building, "" if building in known else why
    point = shapely.Point(entry.at)
    distance = {building: float(shapely.distance(plan, point)) for building, plan in plans.items()}
    building = min(distance, key=lambda b: distance[b], default="")
    if building and distance[building] <= _REACH:
        return building, ""
    near = f"; the nearest, {building}, is {distance[building]:.0f} m away" if building else ""
    x, y = entry.at
    return "", f'the project file puts "{entry.address}" at {x:g}, {y:g}, where no building stands{near}'


def _plans(workspace: "Workspace", records: Sequence[Mapping[str, Any]]) -> dict[str, shapely.Geometry]:
    """The ground plan of every building in world coordinates: its footprint, else the feet of its facades."""
    facades: dict[str, list[shapely.Geometry]] = {}
    for name in workspace.facade_ids():
        facade = workspace.load_facade(name)
        (x0, z0, x1, _) = facade.extent
        feet = facade.frame.apply(np.array([[x0, 0.0, z0], [x1, 0.0, z0]]))
        line = shapely.LineString(facade.world.to_world(feet)[:, :2])
        facades.setdefault(facade.building, []).append(line)
    origin = np.array(workspace.manifest()["world"]["origin"], np.float64)[:2]
    plans: dict[str, shapely.Geometry] = {}
    for record in records:
        parts = list(facades.get(str(record["id"]), []))
        if record["footprint"] is not None:
            parts.append(shapely.Polygon(np.array(record["footprint"]) + origin))
        if parts:
            plans[str(record["id"])] = shapely.union_all(parts)
    return plans
