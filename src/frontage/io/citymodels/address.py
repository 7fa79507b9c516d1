"""Addresses as city models store them: number and street."""

from collections.abc import Mapping
from typing import Any


def split_address(address: str) -> tuple[str, str]:
    """Split an address into its number ("" without one), which stands first or last, and its street."""
    words = address.split()
    if len(words) > 1 and words[0][0].isdigit():
        return words[0], " ".join(words[1:])
    if len(words) > 1 and words[-1][0].isdigit():
        return words[-1], " ".join(words[:-1])
    return "", address


def readable_address(properties: Mapping[str, Any]) -> str | None:
    """The address in attributes with the names of OpenStreetMap, xAL or plain English; None without one."""
    p = {str(k).lower(): v for k, v in properties.items() if isinstance(v, str | int) and str(v).strip()}
    if "address" in p:
        return str(p["address"])
    street = p.get("addr:street", p.get("thoroughfarename", p.get("street")))
    number = p.get("addr:housenumber", p.get("thoroughfarenumber", p.get("housenumber")))
    return " ".join(str(v) for v in (number, street) if v is not None) or None if street else None
