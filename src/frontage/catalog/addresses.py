"""Finds buildings by id or address, however the address is written."""

import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher

from frontage.errors import InputError

# Words and their usual abbreviations, as which they are compared; "st" is street, saint or sankt.
_SHORT = {
    "avenue": "av", "ave": "av", "boulevard": "bd", "blvd": "bd", "place": "pl", "square": "sq", "road": "rd",
    "lane": "ln", "drive": "dr", "court": "ct", "street": "st", "saint": "st", "sankt": "st",
}  # fmt: skip
_NUMBER = re.compile(
    r"\b(\d{1,4})(?:\s*-?\s*(bis|ter|quater|[a-z]))?(?:\s*-\s*(\d{1,4})\s*([a-z])?)?(?=[\s,;./]|$)"
)
_MOST_NAMED = 6  # candidates that a message names


@dataclass(frozen=True)
class Address:
    """An address in the form in which it is compared: house numbers and words of the street.

    "13 bis" has the number "13bis"; "13-17" has the numbers 13, 15 and 17.
    """

    numbers: frozenset[str]
    words: tuple[str, ...]

    @classmethod
    def of(cls, text: str) -> "Address":
        """Parses an address; case, accents, commas, abbreviations and the order do not matter."""
        plain = unicodedata.normalize("NFKD", text.casefold())
        plain = "".join(c for c in plain if not unicodedata.combining(c)).strip()
        found = _house_number(plain)
        rest = plain if found is None else f"{plain[: found.start()]} {plain[found.end() :]}"
        words = tuple(_short(word) for word in re.findall(r"\w+", rest))
        return cls(frozenset(_numbers(found)) if found else frozenset(), words)

    def match(self, known: "Address") -> int:
        """Rates how well this address matches a known one.

        3 = exactly, 2 = all that this one says is in the known one, 1 = the other way round, 0 = not at all.
        """
        if self.numbers and not self.numbers & known.numbers:
            return 0
        if "".join(self.words) == "".join(known.words):
            return 3 if self.numbers or not known.numbers else 2
        mine, theirs = set(self.words), set(known.words)
        if not mine or not theirs:
            return 0
        return 2 if mine <= theirs else int(theirs <= mine)


def find_building(asked: str, known: Mapping[str, Iterable[str]]) -> str:
    """Returns the id of the building that `asked`, an id or an address, refers to.

    `known` maps building ids to their addresses. Raises InputError that names the buildings it may refer to,
    or the most similar address.
    """
    for building in known:
        if building.casefold() == asked.strip().casefold():
            return building
    wanted = Address.of(asked)
    marks = {
        building: max((wanted.match(Address.of(a)) for a in addresses), default=0)
        for building, addresses in known.items()
    }
    best = max(marks.values(), default=0)
    meant = [building for building, mark in marks.items() if best and mark == best]
    if len(meant) == 1:
        return meant[0]
    if meant:
        raise InputError(
            f'"{asked}" matches {len(meant)} buildings: {_listed(meant, known)}; '
            "be more specific or give the id"
        )
    raise InputError(_nothing(asked, known))


def _house_number(plain: str) -> re.Match[str] | None:
    """The number in front, else the one that ends a part between commas, else the last; never a postcode."""
    found = list(_NUMBER.finditer(plain))
    if not found or found[0].start() == 0:
        return found[0] if found else None
    ending = [m for m in found if not plain[m.end() :].strip() or plain[m.end() :].lstrip().startswith(",")]
    return (ending or found[-1:])[0]


def _short(word: str) -> str:
    """Returns the abbreviation of a word, or the word itself."""
    if word.endswith("strasse"):
        return word.removesuffix("asse")
    return _SHORT.get(word, word)


def _numbers(found: re.Match[str]) -> Iterable[str]:
    """Yields "13bis" for "13 bis", and 13, 15 and 17 for "13-17"."""
    first, letter, last, last_letter = found.groups()
    yield first + (letter or "")
    if last is None:
        return
    yield last + (last_letter or "")
    if 0 < int(last) - int(first) < 60:
        yield from (str(n) for n in range(int(first), int(last), 2 - (int(last) - int(first)) % 2))


def _nothing(asked: str, known: Mapping[str, Iterable[str]]) -> str:
    """The message for an address that matches no building: the most similar one, or that there are none."""
    places = [(b, a) for b, addresses in known.items() for a in addresses]
    ids = ", ".join(list(known)[:_MOST_NAMED]) + (", ..." if len(known) > _MOST_NAMED else "") or "none yet"
    if not places:
        return (
            f'no building has the id "{asked}", and none has an address; add some under [addresses] in the '
            f"project file and run again, or give an id: {ids}"
        )
    plain = _plain(asked)
    building, address = max(places, key=lambda p: SequenceMatcher(None, plain, _plain(p[1])).ratio())
    return f'no building has the address or id "{asked}"; the most similar is "{address}" ({building})'


def _plain(text: str) -> str:
    address = Address.of(text)
    return " ".join([*sorted(address.numbers), *address.words])


def _listed(meant: list[str], known: Mapping[str, Iterable[str]]) -> str:
    named = [f"{b} ({', '.join(known[b])})" for b in meant[:_MOST_NAMED]]
    return ", ".join(named) + (", ..." if len(meant) > _MOST_NAMED else "")
