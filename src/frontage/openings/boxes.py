"""Boxes on a facade."""

Box = tuple[float, float, float, float]
"""Left, lower, right and upper border x0, z0, x1, z1 in m, in the facade frame."""
