"""What every reader of CityJSON needs: the packing of vertices, and the position of templates."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float

_VERSIONS = ("0.", "1.", "2.")
_NO_TRANSFORM = ("0.", "1.0")  # from 1.1 on a transform is required


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
    return np.array(transform["scale"], np.float64), np.array(transform["translate"], np.float64)


def template_of(geometry: Any, vertices: Float, templates: Mapping[str, Any]) -> tuple[Any, Float]:
    """The template of a GeometryInstance, and its vertices (v, 3) at the position of the instance.

    Raises KeyError, IndexError, TypeError or ValueError for a malformed instance.
    """
    matrix = np.array(geometry["transformationMatrix"], np.float64).reshape(4, 4)
    anchor = vertices[geometry["boundaries"][0]]
    points = np.array(templates["vertices-templates"], np.float64).reshape(-1, 3)
    moved = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return templates["templates"][geometry["template"]], moved[:, :3] / moved[:, 3:] + anchor
