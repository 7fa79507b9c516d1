"""Values in the records of JSON files: checked when read, and written so that JSON can hold them."""

import math
from typing import Any

import numpy as np

from frontage.model import Estimate, Provenance


def text(r: dict[str, Any], key: str) -> str:
    """Return a text of a record. Raises ValueError for anything else."""
    if not isinstance(r[key], str):
        raise ValueError(f"{key} = {r[key]!r} is no text")
    return str(r[key])


def whole(r: dict[str, Any], key: str) -> int:
    """Return a whole number of a record. Raises ValueError for anything else."""
    if not isinstance(r[key], int) or isinstance(r[key], bool):
        raise ValueError(f"{key} = {r[key]!r} is no whole number")
    return int(r[key])


def truth(r: dict[str, Any], key: str) -> bool:
    """Return a truth value of a record. Raises ValueError for anything else."""
    if not isinstance(r[key], bool):
        raise ValueError(f"{key} = {r[key]!r} is neither true nor false")
    return bool(r[key])


def real(value: Any, key: str) -> float:
    """Return a finite number, the value of `key`. Raises ValueError for anything else."""
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise ValueError(f"{key} = {value!r} is no number")
    return float(value)


def or_infinite(value: Any, key: str) -> float:
    """Return a finite number, or infinity for null, which stands for "not known"."""
    return math.inf if value is None else real(value, key)


def number(value: float) -> float | None:
    """Return a number for JSON, which has no infinity and no NaN: null stands for "not known"."""
    return float(value) if math.isfinite(value) else None


def estimate(value: float, r: dict[str, Any]) -> Estimate[float]:
    """Return a value with the variance, degrees of freedom and provenance of a record."""
    variance = np.array([[or_infinite(r["variance"], "variance")]])
    return Estimate(value, variance, or_infinite(r["dof"], "dof"), Provenance(r["provenance"]))


def estimate_record(e: Estimate[float]) -> dict[str, Any]:
    """Return all of an estimate but its value."""
    return {
        "variance": number(e.covariance[0, 0]),
        "dof": number(e.dof),
        "provenance": str(e.provenance),
    }


def measure_record(e: Estimate[float]) -> dict[str, Any]:
    """Return an estimate with its value."""
    return {"value": float(e.value), **estimate_record(e)}
