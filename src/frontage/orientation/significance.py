"""Limits that one of a thousand good observations exceeds by chance (Baarda 1968)."""

CRITICAL = 3.29
"""Standard errors of a difference."""

CRITICAL_DISTANCE = 3.72
"""Standard errors of a distance in two dimensions."""
