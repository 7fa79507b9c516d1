"""Buildings by id or address, however the address is written."""

import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher

from frontage.errors import InputError

# Each word to its shortest usual form, so that both forms meet; "st" is street, saint and sankt alike.
_SHORT = {
    "avenue": "av", "ave": "av", "boulevard": "bd", "blvd": "bd", "place": "pl", "square": "sq", "road": "rd",
    "lane": "ln", "drive": "dr", "court": "ct", "street": "st", "saint": "st", "sankt": "st",
}  # fmt: skip
_NUMBER = re.compile(
    r"\b(\d{1,4})(?:\s*-?\s*(bis|ter|quater|[a-z]))?(?:\s*-\s*(\d{1,4})\s*([a-z])?)?(?=[\s,;./]|$)"
)
_NAMED = 6  # candidates in a sentence


@dataclass(frozen=True)
class Address:
    """An address as it is compared: house numbers ("13bis"; of "13-17" all three), words of the street."""

    numbers: frozenset[str]
    words: tuple[str, ...]

    @classmethod
    def of(cls, text: str) -> "Address":
        """Case, accents, commas, spaces and the number's place do not matter; usual abbreviations meet."""
        plain = unicodedata.normalize("NFKD", text.casefold())
        plain = "".join(c for c in plain if not unicodedata.combining(c)).strip()
        found = _house_number(plain)
        rest = plain if found is None else f"{plain[: found.start()]} {plain[found.end() :]}"
        words = tuple(_short(word) for word in re.findall(r"\w+", rest))
        return cls(frozenset(_numbers(found)) if found else frozenset(), words)

    def means(self, known: "Address") -> int:
        """How well this means a known address: 3 exactly, 2 in all it says, 1 in all that is known, 0 not."""
        if self.numbers and not self.numbers & known.numbers:
            return 0
        if "".join(self.words) == "".join(known.words):
            return 3 if self.numbers or not known.numbers else 2
        mine, theirs = set(self.words), set(known.words)
        if not mine or not theirs:
            return 0
        return 2 if mine <= theirs else int(theirs <= mine)


def find_building(asked: str, known: Mapping[str, Iterable[str]]) -> str:
    """The id of the building that `asked`, an id or an address, means; known = building id -> its addresses.

    Raises InputError with one sentence: which buildings it may mean, or which address comes nearest.
    """
    for building in known:
        if building.casefold() == asked.strip().casefold():
            return building
    wanted = Address.of(asked)
    marks = {
        building: max((wanted.means(Address.of(a)) for a in addresses), default=0)
        for building, addresses in known.items()
    }
    best = max(marks.values(), default=0)
    meant = [building for building, mark in marks.items() if best and mark == best]
    if len(meant) == 1:
        return meant[0]
    if meant:
        raise InputError(
            f'"{asked}" may mean {len(meant)} buildings: {_listed(meant, known)}; say more, or give the id'
        )
    raise InputError(_nothing(asked, known))


def _house_number(plain: str) -> re.Match[str] | None:
    """The number in front, or the one that ends a part between commas, or the last; never a postcode."""
    found = list(_NUMBER.finditer(plain))
    if not found or found[0].start() == 0:
        return found[0] if found else None
    ending = [m for m in found if not plain[m.end() :].strip() or plain[m.end() :].lstrip().startswith(",")]
    return (ending or found[-1:])[0]


def _short(word: str) -> str:
    if word.endswith("strasse"):
        return word.removesuffix("asse")
    return _SHORT.get(word, word)


def _numbers(found: re.Match[str]) -> Iterable[str]:
    """ "13bis" of "13 bis"; of "13-17" the houses 13, 15 and 17."""
    first, letter, last, last_letter = found.groups()
    yield first + (letter or "")
    if last is None:
        return
    yield last + (last_letter or "")
    if 0 < int(last) - int(first) < 60:
        yield from (str(n) for n in range(int(first), int(last), 2 - (int(last) - int(first)) % 2))


def _nothing(asked: str, known: Mapping[str, Iterable[str]]) -> str:
    """No building: the nearest addresses, or that there are none."""
    places = [(b, a) for b, addresses in known.items() for a in addresses]
    ids = ", ".join(list(known)[:_NAMED]) + (", ..." if len(known) > _NAMED else "") or "none yet"
    if not places:
        return (
            f'no building has the id "{asked}", and none has an address; name them under [addresses] in the '
            f"project file and run again, or give an id: {ids}"
        )
    plain = _plain(asked)
    building, address = max(places, key=lambda p: SequenceMatcher(None, plain, _plain(p[1])).ratio())
    return f'no building has the address or id "{asked}"; the nearest is "{address}" ({building})'


def _plain(text: str) -> str:
    address = Address.of(text)
    return " ".join([*sorted(address.numbers), *address.words])


def _listed(meant: list[str], known: Mapping[str, Iterable[str]]) -> str:
    named = [f"{b} ({', '.join(known[b])})" for b in meant[:_NAMED]]
    return ", ".join(named) + (", ..." if len(meant) > _NAMED else "")
