"""The XML section of an E57 file, found and checked by our own code before a library parses it.

The parser below pye57 resolves document types and entities, which can open other files and network addresses,
and it descends into nested elements without a limit. E57 (ASTM E2807-11, section 8) needs neither.
"""

import re
import struct
from math import ceil, isfinite, log2
from pathlib import Path
from typing import Any
from xml.parsers import expat

from frontage.errors import FileError
from frontage.io.files import require_length

_SIGNATURE = b"ASTM-E57"
_HEADER = 48  # bytes
_PAGE, _CHECKSUM = 1024, 4  # bytes of a page, and of the checksum at its end
_MOST_XML = 64_000_000  # bytes; the sections of thousands of scans have a tenth of it
_MOST_DEPTH = 40  # of nested elements; the standard's own structures have nine levels
_MOST_ELEMENTS = 2_000_000
_ENCODINGS = ("utf-8", "us-ascii")
_NUMBERS = {"pose", "colorLimits", "intensityLimits", "indexBounds"}
"""Structures whose values must be numbers: the parser below pye57 takes other text as 0."""


def check_e57(path: Path) -> None:
    """Check the header and the XML section of an E57 file against its size and against our limits.

    Raises FileError or ValueError when it is not E57, is damaged, has a document type or entities, is nested
    too deeply, states more points than the file can hold, or has a pose that is no number.
    """
    has = path.stat().st_size
    with open(path, "rb") as f:
        head = f.read(_HEADER).ljust(_HEADER, b"\0")
        if head[:8] != _SIGNATURE:
            raise ValueError("it does not begin with 'ASTM-E57'")
        length, at, size, page = struct.unpack_from("<4Q", head, 16)
        require_length(path, f"{length} bytes", length, has)
        if page != _PAGE:
            raise ValueError(f"its pages have {page} bytes instead of {_PAGE}")
        require_length(path, f"an XML section of {size} bytes at byte {at}", at + size, has)
        if size > _MOST_XML:
            raise FileError(
                path, f"its XML section has {size} bytes, too many", "export it again", code="I103"
            )
        f.seek(at // _PAGE * _PAGE)
        stored = f.read((size // (_PAGE - _CHECKSUM) + 2) * _PAGE)
    pages = (stored[k : k + _PAGE - _CHECKSUM] for k in range(0, len(stored), _PAGE))
    xml = b"".join(pages)[at % _PAGE :][:size]
    _Check(path, has).run(xml)


class _Check:
    """The state of one pass over the elements; expat calls its methods."""

    def __init__(self, path: Path, size: int) -> None:
        self.path, self.size = path, size
        self.names: list[str] = []
        self.types: list[str] = []
        self.text = ""
        self.elements = 0
        self.records, self.bits = 0, 0

    def run(self, xml: bytes) -> None:
        """Parse the section. Raises FileError or ValueError."""
        if b"\0" in xml or not xml.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
            raise ValueError("its XML section is not text in UTF-8")
        parser = expat.ParserCreate()
        parser.StartDoctypeDeclHandler = self._forbidden
        parser.EntityDeclHandler = self._forbidden
        parser.XmlDeclHandler = self._declaration
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.buffer_text = True
        parser.Parse(xml, True)

    def _refuse(self, problem: str) -> FileError:
        return FileError(self.path, problem, "export it again", code="I103")

    def _forbidden(self, *_: Any) -> None:
        raise self._refuse("its XML section has a document type or entities, which E57 does not use")

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None and encoding.lower() not in _ENCODINGS:
            raise self._refuse("its XML section is not in UTF-8")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.elements += 1
        if len(self.names) >= _MOST_DEPTH or self.elements > _MOST_ELEMENTS:
            raise self._refuse("its XML section has too many elements, or elements nested too deeply")
        kind, parent = attributes.get("type", ""), self.types[-1] if self.types else ""
        self.names.append(name)
        self.types.append(kind)
        self.text = ""
        if kind == "CompressedVector":
            self.records, self.bits = _whole(attributes.get("recordCount", "0")), 0
        elif "prototype" in self.names and parent == "Structure":
            self.bits += _bits(kind, attributes)

    def _characters(self, text: str) -> None:
        self.text += text

    def _end(self, name: str) -> None:
        kind = self.types.pop()
        self.names.pop()
        if kind in ("Float", "Integer", "ScaledInteger") and _NUMBERS & set(self.names):
            self._require_number(name)
        if kind == "CompressedVector":
            what = f"{self.records} points"
            require_length(self.path, what, self.records * max(self.bits, 1) // 8, self.size)
        self.text = ""

    def _require_number(self, name: str) -> None:
        text = self.text.strip()
        try:
            good = not text or (isfinite(float(text)) and "_" not in text)
        except ValueError:
            good = False
        if not good:
            where = next(n for n in self.names if n in _NUMBERS)
            shown = text if len(text) <= 30 else text[:30] + "..."
            raise self._refuse(f"damaged: {name} in its {where} is {shown!r}, not a number")


def _whole(text: str) -> int:
    """A count. Raises ValueError for text that is not a whole number of a sensible length."""
    if not re.fullmatch(r"\s*-?\d{1,20}\s*", text):
        raise ValueError(f"it states {text[:30]!r} as a number of points")
    return int(text)


def _bits(kind: str, attributes: dict[str, str]) -> int:
    """The bits that a column stores per point."""
    if kind == "Float":
        return 32 if attributes.get("precision") == "single" else 64
    if kind not in ("Integer", "ScaledInteger"):
        return 0
    try:
        low, high = int(attributes.get("minimum", -(2**63))), int(attributes.get("maximum", 2**63 - 1))
    except ValueError:
        return 0
    return ceil(log2(high - low + 1)) if high > low else 0
