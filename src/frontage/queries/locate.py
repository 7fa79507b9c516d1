"""Finds the opening that is meant: "the second window of the third floor of 13 rue Soufflot" (paper A)."""

import re

from frontage.catalog.addressbook import building_at, known_addresses
from frontage.errors import InputError, WorkspaceError
from frontage.model import DOORS, Elements, Opening
from frontage.pipeline.groundplans import ground_plans
from frontage.pipeline.store.store import Store
from frontage.queries.answer import Located, Place, answer

_ID = re.compile(r"(?P<facade>[^/]+[/_]F\d+)/(?P<name>[A-Z]-?\d+-\d+)", re.IGNORECASE)


def locate(
    store: Store,
    address: str,
    *,
    floor: int | None = None,
    window: int | None = None,
    door: int | None = None,
    facade: str | None = None,
) -> Located:
    """Locate an opening by the address or id of its building, floor and number, or by its own id alone.

    Numbers count all openings of the floor from the left as seen from the street, as ids do; `window` takes
    the opening of that number whatever it is, `door` a door, gate or passage. Without `facade` ("F2") it is
    the street facade: the one that shows the most openings.

    Raises InputError with one sentence: what was not found, and what there is.
    """
    found = _ID.fullmatch(address.strip())
    if found:
        if (floor, window, door, facade) != (None, None, None, None):
            raise InputError(
                f"{address} is an opening's id: give it alone, or an address with --floor and --window"
            )
        name, chosen = store.known_facade(found["facade"]), "named by the id"
        place = Place(name.rsplit("/", 1)[0], None, name, chosen)
        elements = _elements(store, name)
        opening = _by_name(elements, f"{name}/{found['name']}")
    else:
        if floor is None or (window is None) == (door is None):
            raise InputError(
                "give --floor and one of --window and --door, or an opening's id such as B01/F1/W3-2"
            )
        place = _place(store, address, facade)
        elements = _elements(store, place.facade)
        opening = _by_number(elements, floor, window, door)
    return answer(store, place, elements, opening)


def _place(store: Store, asked: str, facade: str | None) -> Place:
    names = store.facade_ids()
    by_id = {n.casefold(): n for n in names}.get(asked.strip().replace("_", "/").casefold())
    if by_id and facade is None:
        return Place(by_id.rsplit("/", 1)[0], None, by_id, "asked for")
    book = store.project().addresses
    plans = ground_plans(store) if any(entry.at for entry in book) else {}
    known, lost = known_addresses({r.id: r.address for r in store.building_records()}, plans, book)
    building = building_at(asked, known, lost)
    own = [n for n in names if n.rsplit("/", 1)[0] == building]
    if not own:
        raise InputError(f"{building} has no facade in {store.out}; its warnings in the report say why")
    address = asked if asked.strip().casefold() != building.casefold() else None
    if facade is None:
        front = _street_facade(store, own)
        others = ", ".join(name for name in own if name != front)
        why = f"the one with the most openings, before {others}" if others else "the only one of the building"
        return Place(building, address, front, why)
    wanted = facade.replace("_", "/").casefold()
    for name in own:
        if wanted in (name.casefold(), name.rsplit("/", 1)[1].casefold()):
            return Place(building, address, name, "asked for")
    raise InputError(f"{building} has no facade {facade}; it has {', '.join(own)}")


def _street_facade(store: Store, names: list[str]) -> str:
    """Return the facade that shows the most openings, the first of equal ones."""

    def count(name: str) -> int:
        elements = store.elements(name)
        return len(elements.openings) if elements else -1

    return max(names, key=count)


def _elements(store: Store, name: str) -> Elements:
    elements = store.elements(name)
    if elements is None:
        folder = store.facade_folder(name)
        raise WorkspaceError(f"{folder} has no openings.json; make it with `frontage openings {store.out}`")
    return elements


def _by_name(elements: Elements, id: str) -> Opening:
    for opening in elements.openings:
        if opening.id.casefold() == id.casefold():
            return opening
    floor = int(re.split(r"(?<=\d)-", id.rsplit("/", 1)[1][1:])[0])
    raise InputError(f"no opening {id}; {_there(elements, floor)}")


def _by_number(elements: Elements, floor: int, window: int | None, door: int | None) -> Opening:
    number = window if door is None else door
    for opening in elements.openings:
        if opening.floor == floor and opening.number == number and (door is None or opening.kind in DOORS):
            return opening
    what = "opening" if door is None else "door"
    raise InputError(f"{elements.facade} has no {what} {number} on floor {floor}; {_there(elements, floor)}")


def _there(elements: Elements, floor: int) -> str:
    """Say what can be asked for instead."""
    names = [o.id.rsplit("/", 1)[1] for o in elements.openings if o.floor == floor]
    if names:
        return f"there, from the left: {', '.join(names)}"
    floors = sorted({o.floor for o in elements.openings})
    return (
        f"openings were found on floors {', '.join(map(str, floors))}" if floors else "none was found on it"
    )
