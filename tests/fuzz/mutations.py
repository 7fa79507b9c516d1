"""Changes to a file: any bytes, numbers in text, and lies in the headers of binary formats.

A mutation takes a random generator and the bytes of a file, and returns other bytes. `MUTATIONS` lists them
by the family of the format; those of "bytes" suit every file.
"""

import random
import re
import struct
from collections.abc import Callable

from fuzz.containers import change_geopackage, change_npz, change_png, in_e57_stream, in_e57_xml
from fuzz.trees import JSON, XML

Mutation = Callable[[random.Random, bytes], bytes]

NUMBERS = (
    b"0", b"-1", b"1", b"2147483648", b"9223372036854775808", b"18446744073709551615", b"4294967295",
    b"1e308", b"-1e308", b"1e-308", b"1e10", b"NaN", b"inf", b"", b"1.5", b"0x10", b"1e999",
)  # fmt: skip
_WHOLE = {"<B": (0, 1, 3, 127, 128, 255), "<H": (0, 1, 32767, 32768, 65535),
          "<I": (0, 1, 1000, 2**31 - 1, 2**31, 2**32 - 1),
          "<Q": (0, 1, 2**31, 2**32, 2**62, 2**63, 2**64 - 1)}  # fmt: skip
_REAL = (0.0, -0.0, -1.0, 1e-300, 1e10, 1e300, float("nan"), float("inf"), float("-inf"))


def flip(r: random.Random, data: bytes) -> bytes:
    """One to sixteen bits are flipped."""
    out = bytearray(data)
    for _ in range(r.choice((1, 1, 2, 4, 16))):
        out[r.randrange(len(out))] ^= 1 << r.randrange(8)
    return bytes(out)


def flip_head(r: random.Random, data: bytes) -> bytes:
    """A byte among the first 400 gets another value."""
    out = bytearray(data)
    out[r.randrange(min(400, len(out)))] = r.choice((0, 1, 0x20, 0x7F, 0x80, 0xFF, r.randrange(256)))
    return bytes(out)


def truncate(r: random.Random, data: bytes) -> bytes:
    """The end is missing."""
    return data[: r.randrange(len(data))]


def insert(r: random.Random, data: bytes) -> bytes:
    """Up to 300 bytes are put in: zeros, ones, or any."""
    at, length = r.randrange(len(data) + 1), r.choice((1, 2, 4, 17, 300))
    return data[:at] + r.choice((b"\0" * length, b"\xff" * length, r.randbytes(length))) + data[at:]


def delete(r: random.Random, data: bytes) -> bytes:
    """Up to 300 bytes are taken out."""
    at = r.randrange(len(data))
    return data[:at] + data[at + r.choice((1, 2, 4, 17, 300)) :]


def repeat(r: random.Random, data: bytes) -> bytes:
    """A block is written up to 200 times."""
    at, length = r.randrange(len(data)), r.choice((1, 3, 16, 200))
    block = data[at : at + length]
    return data[:at] + block * r.choice((2, 3, 20, 200)) + data[at + length :]


def overwrite(r: random.Random, data: bytes) -> bytes:
    """A block gets the bytes of another place."""
    at, start, length = r.randrange(len(data)), r.randrange(len(data)), r.choice((1, 4, 8, 64, 500))
    block = data[start : start + length]
    return data[:at] + block + data[at + len(block) :]


def binary_number(r: random.Random, data: bytes) -> bytes:
    """A binary number somewhere gets an extreme value."""
    kind = r.choice(("<H", "<I", "<Q", "<d"))
    step = struct.calcsize(kind)
    at = min(r.randrange(len(data)), max(0, len(data) - step))
    if r.random() < 0.7:
        at -= at % min(step, 4)
    packed = struct.pack(kind, r.choice(_REAL) if kind == "<d" else r.choice(_WHOLE[kind]))
    return data[:at] + packed + data[at + step :]


def first_numbers(r: random.Random, data: bytes) -> bytes:
    """One of the numbers at the beginning, where counts stand, gets an extreme value."""
    kind = r.choice(("<I", "<Q"))
    at = r.choice((0, 4, 8, 12, 16, 20, 24))
    return data[:at] + struct.pack(kind, r.choice(_WHOLE[kind])) + data[at + struct.calcsize(kind) :]


def text_number(r: random.Random, data: bytes) -> bytes:
    """A number in the text becomes another one, or none."""
    found = list(re.finditer(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", data))
    if not found:
        return data
    one = r.choice(found)
    return data[: one.start()] + r.choice(NUMBERS) + data[one.end() :]


def text_word(r: random.Random, data: bytes) -> bytes:
    """A word is lost, doubled, very long, or no UTF-8."""
    found = list(re.finditer(rb"\S+", data))
    if not found:
        return data
    one = r.choice(found)
    word = one.group()
    other = r.choice((b"", word * 2, word + b" " + word, b"A" * 5000, b"\xff\xfe", b"\0", b"\x1b[31m", b"-"))
    return data[: one.start()] + other + data[one.end() :]


def text_line(r: random.Random, data: bytes) -> bytes:
    """A line is lost, doubled, moved, or many times as long."""
    lines = data.split(b"\n")
    at = r.randrange(len(lines))
    what = r.randrange(4)
    if what == 0:
        del lines[at]
    elif what == 1:
        lines.insert(at, lines[at])
    elif what == 2:
        lines.insert(r.randrange(len(lines)), lines.pop(at))
    else:
        lines[at] = lines[at] * 1000
    return b"\n".join(lines)


def text_head_number(r: random.Random, data: bytes) -> bytes:
    """A number in the header of a PLY file becomes another one."""
    end = data.find(b"end_header")
    head, rest = data[:end], data[end:]
    return (text_word if r.random() < 0.3 else text_number)(r, head) + rest


# Offsets in a LAS header: counts, sizes, positions; then scales, offsets, bounds.
_LAS_WHOLE = ((24, "<B"), (25, "<B"), (94, "<H"), (96, "<I"), (100, "<I"), (104, "<B"), (105, "<H"),
              (107, "<I"), (111, "<I"), (235, "<Q"), (243, "<I"), (247, "<Q"))  # fmt: skip
_LAS_REAL = tuple(range(131, 227, 8))


def las_lie(r: random.Random, data: bytes) -> bytes:
    """A count, size, position, scale or offset in a LAS header is a lie."""
    if r.random() < 0.4:
        at, packed = r.choice(_LAS_REAL), struct.pack("<d", r.choice(_REAL))
    else:
        at, kind = r.choice(_LAS_WHOLE)
        (old,) = struct.unpack_from(kind, data, at)
        top = 256 ** struct.calcsize(kind)
        packed = struct.pack(kind, r.choice((*_WHOLE[kind], (old + 1) % top, (old - 1) % top, old // 2)))
    return data[:at] + packed + data[at + len(packed) :]


def las_record(r: random.Random, data: bytes) -> bytes:
    """The length, user or number of the first variable length record is a lie."""
    (start,) = struct.unpack_from("<H", data, 94)
    at = start + r.choice((2, 18, 20, 54, 56, 66, 74))
    if at + 2 > len(data):
        return data
    return data[:at] + struct.pack("<H", r.choice(_WHOLE["<H"])) + data[at + 2 :]


def jpeg_segment(r: random.Random, data: bytes) -> bytes:
    """A length or a dimension in a JPEG's segments is a lie, or the end is cut off and closed again."""
    if r.random() < 0.3:
        return data[: r.randrange(len(data) // 4, len(data))] + b"\xff\xd9"
    markers = [m.start() for m in re.finditer(rb"\xff[\xc0-\xef]", data)]
    at = r.choice(markers) + r.choice((2, 3, 5, 7, 9))
    return data[:at] + struct.pack(">H", r.choice(_WHOLE["<H"])) + data[at + 2 :]


def toml_key(r: random.Random, data: bytes) -> bytes:
    """A value of a project file gets another type, an unusable path or deep brackets."""
    lines = data.split(b"\n")
    at = r.choice([k for k, line in enumerate(lines) if b"=" in line])
    key = lines[at].split(b"=")[0]
    values = (
        b"nan", b"[nan, inf, -inf]", b"-inf", b'"/"', b'"~nouser/x"', b'"a\\u0000b"',
        b'"' + b"x" * 300 + b'"', b"{a = 1}", b"[" * 3000 + b"]" * 3000, b"[]", b"true", b'""',
        b"2020-01-01", b'"/dev/zero"', b'"\\u001b[31m"', b"9" * 5000,
    )  # fmt: skip
    lines[at] = key + b"= " + r.choice(values)
    return (b"\xef\xbb\xbf" if r.random() < 0.1 else b"") + b"\n".join(lines)


BYTES: tuple[Mutation, ...] = (flip, flip_head, truncate, insert, delete, repeat, overwrite)
TEXT: tuple[Mutation, ...] = (text_number, text_number, text_number, text_word, text_line)

MUTATIONS: dict[str, tuple[Mutation, ...]] = {
    "bytes": BYTES,
    "numbers": (binary_number, binary_number, first_numbers),
    "text": TEXT,
    "head": (text_head_number, text_head_number, binary_number),
    "las": (las_lie, las_lie, las_lie, las_record, binary_number),
    "e57": (in_e57_xml(text_number), in_e57_xml(text_number), in_e57_xml(XML[0]),
            in_e57_xml(XML[-2]), in_e57_xml(XML[-1]), in_e57_stream(binary_number)),
    "npz": change_npz,
    "jpeg": (jpeg_segment, jpeg_segment, binary_number),
    "png": change_png,
    "json": (*JSON, text_number),
    "xml": (*XML, text_number, text_number),
    "gpkg": change_geopackage,
    "toml": (toml_key,),
}  # fmt: skip
"""The mutations of every family."""


def mutations(kinds: tuple[str, ...]) -> tuple[Mutation, ...]:
    """The mutations of some families; half of all changes keep to the structure of the format."""
    known = tuple(m for kind in kinds for m in MUTATIONS[kind])
    return known * max(1, len(BYTES) // max(1, len(known))) + BYTES
