"""JSON files read piece by piece: one member of an object, or one entry of a large member, at a time.

A file may be larger than memory: only the current value is decoded, by the standard library.
"""

import json
from collections.abc import Iterator
from json.decoder import JSONDecodeError
from pathlib import Path
from typing import Any, TextIO

_STEP = 1 << 20  # characters that are read at a time
_TOO_DEEP = "its values are nested too deeply"
_SPACE = " \t\r\n\x1e"  # record separators stand between the texts of a JSON sequence (RFC 7464)


def parse_json(text: str) -> Any:
    """The value of a JSON text. Raises JSONDecodeError on damage, ValueError for one nested too deeply."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None


class _Text:
    """A window on the text of a file: it grows at its end, and what was decoded is dropped."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self._text = ""
        self._at = 0
        self._dropped = 0
        self._decoder = json.JSONDecoder()

    def _more(self) -> bool:
        """Read more text and drop what was decoded; False at the end of the file."""
        step = self._file.read(max(_STEP, len(self._text) - self._at))
        self._dropped += self._at
        self._text, self._at = self._text[self._at :] + step, 0
        return bool(step)

    def peek(self) -> str:
        """The next character that is not a space; "" at the end."""
        while True:
            while self._at < len(self._text) and self._text[self._at] in _SPACE:
                self._at += 1
            if self._at < len(self._text):
                return self._text[self._at]
            if not self._more():
                return ""

    def take(self, expected: str) -> str:
        """Skip the next character. Raises ValueError when it is none of those expected."""
        found = self.peek()
        if not found or found not in expected:
            what = " or ".join(f"'{c}'" for c in expected)
            raise ValueError(f"{what} expected at character {self._dropped + self._at}")
        self._at += 1
        return found

    def value(self) -> Any:
        """Decode the next value. Raises ValueError with the position of damage."""
        self.peek()
        while True:
            try:
                found, end = self._decoder.raw_decode(self._text, self._at)
            except JSONDecodeError as problem:
                if self._more():
                    continue
                place = self._dropped + problem.pos
                raise ValueError(f"{problem.msg} at character {place}") from problem
            except RecursionError:
                raise ValueError(_TOO_DEEP) from None
            if end == len(self._text) and self._more():
                continue  # a number could continue
            self._at = end
            return found

    def entries(self) -> Iterator[tuple[Any, Any]]:
        """(key, value) of an object, (number, value) of an array."""
        closing = "}" if self.take("{[") == "{" else "]"
        if self.peek() == closing:
            self.take(closing)
            return
        number = 0
        while True:
            key: Any = number
            if closing == "}":
                key = self.value()
                self.take(":")
            yield key, self.value()
            number += 1
            if self.take("," + closing) == closing:
                return


def members(path: Path, large: tuple[str, ...] = ()) -> Iterator[tuple[int, str, Any, Any]]:
    """Yield the members of a file's objects: (number of the object, name, None, value).

    Members named in `large` come entry by entry instead, with their key or number in place of None.

    Raises ValueError when the file is damaged or does not hold objects.
    """
    with open(path, encoding="utf-8-sig") as file:
        text = _Text(file)
        document = 0
        while document == 0 or text.peek() != "":
            for name, key, value in _object(text, large):
                yield document, name, key, value
            document += 1


def first_type(path: Path) -> Any:
    """The member `type` of the first object in a file; None when it has none. Raises ValueError on damage."""
    large = ("features", "CityObjects", "vertices")
    kinds = (value for document, name, _, value in members(path, large) if name == "type" or document)
    return next(kinds, None)


def _object(text: _Text, large: tuple[str, ...]) -> Iterator[tuple[str, Any, Any]]:
    text.take("{")
    if text.peek() == "}":
        text.take("}")
        return
    while True:
        name = text.value()
        text.take(":")
        if name in large and text.peek() in ("{", "["):
            for key, value in text.entries():
                yield name, key, value
        else:
            yield name, None, text.value()
        if text.take(",}") == "}":
            return
