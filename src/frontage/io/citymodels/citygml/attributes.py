"""Attributes and addresses of CityGML objects."""

from lxml import etree

from frontage.io.citymodels.citygml.geometry import local
from frontage.io.citymodels.draft import Value

_FLOATS = ("measuredHeight",)
_WHOLE = ("storeysAboveGround", "storeysBelowGround")
_NAMES = ("ThoroughfareName", "NameElement")
_NUMBERS = ("ThoroughfareNumber", "Number")


def attributes_of(element: etree._Element) -> dict[str, Value]:
    """Plain properties (function, roofType, measuredHeight in m, ...) and generic attributes by name."""
    found: dict[str, Value] = {}
    for child in element:
        name = local(child)
        inside = [c for c in child if isinstance(c.tag, str)]
        if name.endswith("Attribute"):
            found.update(_generic(inside[0] if name == "genericAttribute" and inside else child))
        elif name == "height" and (value := _below(child, "value")):
            found["measuredHeight"] = _typed(value, float)
        elif name and not inside and (text := (child.text or "").strip()):
            kind = float if name in _FLOATS else int if name in _WHOLE else str
            found.setdefault(name, _typed(text, kind))
    return found


def _generic(element: etree._Element) -> dict[str, Value]:
    """One generic attribute; its name is an attribute of the element (CityGML 1 and 2) or a child (3)."""
    name = element.get("name") or _below(element, "name")
    text = _below(element, "value")
    kind = {"int": int, "double": float, "measure": float}.get(
        local(element).removesuffix("Attribute").lower(), str
    )
    return {name: _typed(text, kind)} if name and text else {}


def _below(element: etree._Element, name: str) -> str:
    """The text of the first element with a name at or below another; "" without one."""
    return next(((e.text or "").strip() for e in element.iter() if local(e) == name), "")


def _typed(text: str, kind: type[str] | type[int] | type[float]) -> Value:
    """The text converted to a type; unchanged where it is not of that type."""
    try:
        return kind(text)
    except ValueError:
        return text


def address_of(element: etree._Element) -> tuple[str | None, list[str]]:
    """The first xAL address of a building (not of its parts) as "number street", and the further ones."""
    found = []
    for child in element:
        if local(child) == "address":
            found += [text for e in child.iter() if local(e) == "Thoroughfare" and (text := _street(e))]
    found = list(dict.fromkeys(found))
    return (found[0] if found else None), found[1:]


def _street(thoroughfare: etree._Element) -> str:
    """Number and name of a street as one text; "" without a name."""
    text: dict[str, str] = {}
    for e in thoroughfare.iter():
        if words := " ".join((e.text or "").split()):
            text.setdefault(local(e), words)
    street = next((text[n] for n in _NAMES if n in text), "")
    number = next((text[n] for n in _NUMBERS if n in text), "")
    return " ".join(v for v in (number, street) if v) if street else ""
