"""Changes to the structure of JSON and XML: nodes that are lost, replaced, nested, doubled or renamed."""

import json
import random
from collections.abc import Callable
from typing import Any

from lxml import etree

Mutation = Callable[[random.Random, bytes], bytes]

_VALUES: tuple[Any, ...] = (
    None, 0, -1, 2**31, 2**63, 10**400, 1e308, float("nan"), float("inf"), "", "x", "\x1b[31m", "a\0b",
    [], {}, [[]], [[[]]], True, [None], {"type": "Solid"},
)  # fmt: skip
_TEXTS = ("", "0", "-1", "1e308", "NaN", "1 2", "x", "2147483648", "9223372036854775808", "1 2 3 " * 500)


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Every node of a JSON value, as its container and the key or index in it."""
    found, left = [], [value]
    while left:
        one = left.pop()
        keys = list(one) if isinstance(one, dict) else range(len(one)) if isinstance(one, list) else ()
        found += [(one, key) for key in keys]
        left += [one[key] for key in keys]
    return found


def _json_change(change: Callable[[random.Random, Any, Any], None]) -> Mutation:
    """A change of one node, for JSON files and for lines of JSON."""

    def mutate(r: random.Random, data: bytes) -> bytes:
        try:
            values = [json.loads(data)]
        except ValueError:
            values = [json.loads(line) for line in data.splitlines() if line]
        places = _places(r.choice(values))
        if places:
            change(r, *r.choice(places))
        return "\n".join(json.dumps(value) for value in values).encode()

    mutate.__name__ = change.__name__
    return mutate


def json_delete(r: random.Random, holder: Any, key: Any) -> None:
    """A node is lost."""
    del holder[key]


def json_replace(r: random.Random, holder: Any, key: Any) -> None:
    """A node becomes a value of another kind."""
    holder[key] = r.choice(_VALUES)


def json_nest(r: random.Random, holder: Any, key: Any) -> None:
    """A node is put into one to five lists, or into an object."""
    for _ in range(r.choice((1, 1, 2, 5))):
        holder[key] = [holder[key]]
    if r.random() < 0.2:
        holder[key] = {"type": holder[key]}


def json_flatten(r: random.Random, holder: Any, key: Any) -> None:
    """A list is replaced by its first entry."""
    value = holder[key]
    holder[key] = value[0] if isinstance(value, list) and value else value


def json_double(r: random.Random, holder: Any, key: Any) -> None:
    """The entries of a list come twice or fifty times; a text is doubled."""
    if isinstance(holder[key], (list, str)):
        holder[key] = holder[key] * r.choice((2, 50))


def json_rename(r: random.Random, holder: Any, key: Any) -> None:
    """A key is renamed; an entry of a list changes its place."""
    value = holder.pop(key)
    if isinstance(holder, dict):
        holder[r.choice(("x", "type", str(key) + "s", ""))] = value
    else:
        holder.insert(r.randrange(len(holder) + 1), value)


def json_deep(r: random.Random, data: bytes) -> bytes:
    """A value is nested many thousand times."""
    depth = r.choice((500, 2000, 100_000))
    opening, closing = r.choice(((b"[", b"]"), (b'{"a":', b"}")))
    at = data.find(b":", r.randrange(len(data))) + 1
    return data[:at] + opening * depth + b"1" + closing * depth + b"," + b'"z":' + data[at:]


_CHANGES = (json_delete, json_replace, json_replace, json_nest, json_flatten, json_double, json_rename)
JSON = (*map(_json_change, _CHANGES), json_deep)


def _xml_change(change: Callable[[random.Random, Any], None]) -> Mutation:
    """A change of one element below the root."""

    def mutate(r: random.Random, data: bytes) -> bytes:
        root = etree.fromstring(data)
        elements = [e for e in root.iter() if isinstance(e.tag, str)]
        change(r, r.choice(elements[1:] or elements))
        return etree.tostring(root, xml_declaration=True, encoding="UTF-8")

    mutate.__name__ = change.__name__
    return mutate


def xml_text(r: random.Random, element: Any) -> None:
    """The text of an element is another one."""
    element.text = r.choice(_TEXTS)


def xml_attribute(r: random.Random, element: Any) -> None:
    """An attribute is lost or gets another value."""
    for holder in (element, *element.iterancestors(), *element.iter()):
        if holder.attrib:
            name = r.choice(list(holder.attrib))
            if r.random() < 0.3:
                del holder.attrib[name]
            else:
                holder.attrib[name] = r.choice((*_TEXTS, "#x", "EPSG:999999", "http://localhost/x", "9999"))
            return


def xml_delete(r: random.Random, element: Any) -> None:
    """An element is lost."""
    if element.getparent() is not None:
        element.getparent().remove(element)


def xml_double(r: random.Random, element: Any) -> None:
    """An element comes again, up to fifty times."""
    parent = element.getparent()
    if parent is not None:
        for _ in range(r.choice((1, 50))):
            parent.append(etree.fromstring(etree.tostring(element)))


def xml_nest(r: random.Random, element: Any) -> None:
    """An element is put into elements of its own name, up to 400 deep."""
    parent = element.getparent()
    if parent is None:
        return
    at = parent.index(element)
    for _ in range(r.choice((1, 3, 200, 400))):
        outer = etree.Element(element.tag)
        outer.append(element)
        element = outer
    parent.insert(at, element)


def xml_rename(r: random.Random, element: Any) -> None:
    """An element is called otherwise, or as its parent."""
    parent = element.getparent()
    element.tag = r.choice(("x", "{http://x}Building", parent.tag if parent is not None else "y"))


def xml_deep(r: random.Random, data: bytes) -> bytes:
    """An element is nested many thousand times."""
    at = data.rfind(b"</")
    depth = r.choice((1000, 100_000))
    return data[:at] + b"<a>" * depth + b"</a>" * depth + data[at:]


def xml_doctype(r: random.Random, data: bytes) -> bytes:
    """A DOCTYPE that expands, reads a file, or asks for a parameter entity."""
    nested = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 10))
    inside = r.choice(
        (
            '<!ENTITY e0 "lol">' + nested,
            '<!ENTITY e9 SYSTEM "file:///dev/zero">',
            '<!ENTITY % p SYSTEM "file:///dev/zero"> %p;',
        )
    )
    start = data.find(b"?>") + 2 if data.startswith(b"<?xml") else 0
    end = data.find(b">", data.find(b"<", start)) + 1
    doctype = f"<!DOCTYPE x [{inside}]>".encode()
    return data[:start] + doctype + data[start:end] + b"&e9;" + data[end:]


_XML_CHANGES = (
    xml_text, xml_text, xml_attribute, xml_attribute, xml_delete, xml_double, xml_nest, xml_rename,
)  # fmt: skip
XML = (*map(_xml_change, _XML_CHANGES), xml_deep, xml_doctype)
