"""Boxes on a facade."""

Box = tuple[float, float, float, float]
"""Left, lower, right and upper border x0, z0, x1, z1 in m, in the facade frame."""


def grown(box: Box, by: float) -> Box:
    """Returns the box, larger by `by` m on all sides."""
    return box[0] - by, box[1] - by, box[2] + by, box[3] + by
