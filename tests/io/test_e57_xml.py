"""The XML section of an E57 file is checked before a library parses it."""

import os
import re
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import FileError
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.e57xml import check_e57
from frontage.io.scans.read import read_scans
from frontage.model import WorldRef
from io_files import write_e57

PAGE, PAYLOAD = 1024, 1020


def rewritten(path: Path, change: Callable[[str], str | bytes]) -> Path:
    """The file with another XML section; the checksums of its pages are left out."""
    data = path.read_bytes()
    _, at, size, _ = struct.unpack_from("<4Q", data, 16)
    stored = b"".join(data[k : k + PAYLOAD] for k in range(0, len(data), PAGE))
    start = at // PAGE * PAYLOAD + at % PAGE
    xml = change(stored[start : start + size].decode())
    xml = xml if isinstance(xml, bytes) else xml.encode()
    stored = stored[:start] + xml
    pages = -(-len(stored) // PAYLOAD)
    stored = bytearray(stored.ljust(pages * PAYLOAD, b"\0"))
    struct.pack_into("<4Q", stored, 16, pages * PAGE, at, len(xml), PAGE)
    path.write_bytes(
        b"".join(bytes(stored[k * PAYLOAD : (k + 1) * PAYLOAD]) + bytes(4) for k in range(pages))
    )
    return path


def doctype(text: str, body: str) -> Callable[[str], str]:
    head = '<?xml version="1.0" encoding="UTF-8"?>'
    return lambda xml: xml.replace(head, f"{head}\n<!DOCTYPE e57Root {text}>").replace("ASTM E57", body)


def put(name: str, value: str, count: int = 1) -> Callable[[str], str]:
    def change(xml: str) -> str:
        pattern = rf'<{name} type="(\w+)"(?:/>|>[^<]*</{name}>)'
        assert re.search(pattern, xml)
        return re.sub(pattern, rf'<{name} type="\1">{value}</{name}>', xml, count=count)

    return change


def nested(xml: str) -> str:
    deep = '<a type="Structure">' * 100_000 + "</a>" * 100_000
    return xml.replace("</e57Root>", deep + "</e57Root>")


def utf16(xml: str) -> bytes:
    return xml.replace("UTF-8", "UTF-16").encode("utf-16")


BAD: dict[str, tuple[Callable[[str], str | bytes], str]] = {
    "document type": (doctype('SYSTEM "http://127.0.0.1:9/x.dtd"', "ASTM E57"), "document type"),
    "entity": (doctype('[<!ENTITY x SYSTEM "file:///etc/passwd">]', "&x;"), "document type"),
    "parameter entity": (doctype('[<!ENTITY % x SYSTEM "file:///etc/passwd"> %x;]', "E"), "document type"),
    "laughs": (doctype('[<!ENTITY a "ha"><!ENTITY b "&a;&a;">]', "&b;"), "document type"),
    "nested": (nested, "nested too deeply"),
    "another encoding": (utf16, "not text in UTF-8"),
    "declared encoding": (lambda x: x.replace("UTF-8", "UTF-7"), "not in UTF-8"),
    "open element": (lambda x: x.replace("</e57Root>", ""), "no element found"),
    "position": (put("x", "north"), "x in its pose is 'north', not a number"),
    "position infinite": (put("x", "1e999"), "not a number"),
    "position nan": (put("y", "nan"), "not a number"),
    "decimal comma": (put("z", "6,78"), "not a number"),
    "rotation": (put("w", "0.5.5"), "w in its pose"),
    "bounds": (put("rowMaximum", "many"), "rowMaximum in its indexBounds"),
    "points": (lambda x: re.sub(r'recordCount="\d+"', 'recordCount="1000000000"', x), "1000000000 points"),
    "no number of points": (lambda x: re.sub(r'recordCount="\d+"', 'recordCount="x"', x), "number of points"),
    "negative": (lambda x: re.sub(r'recordCount="\d+"', 'recordCount="-1"', x), "-1 points"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_sections_are_refused(tmp_path: Path, case: str) -> None:
    change, message = BAD[case]
    path = rewritten(write_e57(tmp_path / "a.e57"), change)
    with pytest.raises(FileError) as e:
        read_scans(path)
    assert message in str(e.value) and "a.e57" in str(e.value) and "\n" not in str(e.value)


def test_a_pipe_named_in_a_document_type_is_never_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    path = rewritten(write_e57(tmp_path / "a.e57"), doctype(f'SYSTEM "file://{tmp_path}/pipe"', "ASTM E57"))
    for read in (read_scans, lambda p: read_photos(PhotoSource(path=str(p)), WorldRef(np.zeros(3), None))):
        with pytest.raises(FileError, match="document type"):
            read(path)


def test_an_unchanged_section_passes(tmp_path: Path) -> None:
    check_e57(write_e57(tmp_path / "a.e57"))
    check_e57(rewritten(tmp_path / "a.e57", lambda xml: xml))


@pytest.mark.parametrize("at", [16, 24, 32, 40])
@pytest.mark.parametrize("value", [0, 2**40, 2**64 - 1])
def test_header_of_the_file(tmp_path: Path, at: int, value: int) -> None:
    path = write_e57(tmp_path / "a.e57")
    data = bytearray(path.read_bytes())
    struct.pack_into("<Q", data, at, value)
    path.write_bytes(data)
    with pytest.raises(FileError, match=r"a\.e57"):
        read_scans(path)
    struct.pack_into("<4Q", data, 16, len(data), 10, 2**63, PAGE)
    path.write_bytes(data)
    with pytest.raises(FileError, match="XML section of"):
        read_scans(path)


@pytest.mark.parametrize("quaternion", [(0.5, 0, 0, 0), (0, 0, 0, 0), (2, 0, 0, 1)])
def test_a_rotation_is_a_unit_quaternion(tmp_path: Path, quaternion: tuple[float, ...]) -> None:
    import pye57

    from io_files import e57_columns

    e57 = pye57.E57(str(tmp_path / "q.e57"), mode="w")
    e57.write_scan_raw(e57_columns(), rotation=np.array(quaternion, float), translation=np.zeros(3))
    e57.close()
    with pytest.raises(FileError, match="quaternion"):
        read_scans(tmp_path / "q.e57")
