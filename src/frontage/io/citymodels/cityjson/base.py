"""What every reader of CityJSON needs: the packing of vertices, and the position of templates."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float

_AXES = 3
_VERSIONS = ("0.", "1.", "2.")
_NO_TRANSFORM = ("0.", "1.0")  # from 1.1 on a transform is required


def vertex_table(rows: Any) -> Float:
    """Rows of three numbers as an array (v, 3). Raises ValueError for anything else."""
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == 3 for row in rows):
        raise ValueError("its vertices are not rows of three coordinates")
    try:
        return np.array(rows, np.float64).reshape(-1, 3)
    except (TypeError, ValueError, OverflowError) as problem:
        raise ValueError("a vertex has a coordinate that is not a number") from problem


def transform_of(head: Mapping[str, Any]) -> tuple[Float, Float]:
    """Scale and shift (3,) of the vertices of a CityJSON object.

    Raises ValueError for an unknown version or a missing transform, and KeyError or TypeError for a malformed
    one.
    """
    version = str(head.get("version", ""))
    if not version.startswith(_VERSIONS):
        raise ValueError(f"its CityJSON version {version!r} is not supported; 1.0, 1.1 and 2.0 are")
    transform = head.get("transform")
    if transform is None:
        if not version.startswith(_NO_TRANSFORM):
            raise ValueError("the member transform is missing")
        return np.ones(3), np.zeros(3)
    both = [transform[name] for name in ("scale", "translate")]
    if not all(isinstance(v, list) and len(v) == _AXES for v in both):
        raise ValueError("the transform needs a scale and a translate of three numbers each")
    scale, shift = np.array(both, np.float64)
    if not np.isfinite([scale, shift]).all() or (scale <= 0).any():
        raise ValueError("the transform has a scale that is not positive, or a number that is not finite")
    return scale, shift


def template_of(geometry: Any, vertices: Float, templates: Mapping[str, Any]) -> tuple[Any, Float]:
    """The template of a GeometryInstance, and its vertices (v, 3) at the position of the instance.

    Raises KeyError, IndexError, TypeError or ValueError for a malformed instance.
    """
    if templates["templates"][geometry["template"]]["type"] == "GeometryInstance":
        raise ValueError("a template that is itself an instance of a template")
    matrix = np.array(geometry["transformationMatrix"], np.float64).reshape(4, 4)
    anchor = vertices[geometry["boundaries"][0]]
    points = vertex_table(templates["vertices-templates"])
    moved = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return templates["templates"][geometry["template"]], moved[:, :3] / moved[:, 3:] + anchor
