"""Addresses, as city models keep them: number and street."""

from collections.abc import Mapping
from typing import Any


def split_address(address: str) -> tuple[str, str]:
    """Number ("" where there is none) and street of an address, the number first or last."""
    words = address.split()
    if len(words) > 1 and words[0][0].isdigit():
        return words[0], " ".join(words[1:])
    if len(words) > 1 and words[-1][0].isdigit():
        return words[-1], " ".join(words[:-1])
    return "", address


def spoken_address(properties: Mapping[str, Any]) -> str | None:
    """A readable address from the usual attribute names (OpenStreetMap, xAL, plain), or None."""
    p = {str(k).lower(): v for k, v in properties.items() if isinstance(v, str | int) and str(v).strip()}
    if "address" in p:
        return str(p["address"])
    street = p.get("addr:street", p.get("thoroughfarename", p.get("street")))
    number = p.get("addr:housenumber", p.get("thoroughfarenumber", p.get("housenumber")))
    return " ".join(str(v) for v in (number, street) if v is not None) or None if street else None
