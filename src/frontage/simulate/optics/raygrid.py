"""The viewing directions of all pixels of a camera, interpolated from exact ones on a coarse grid.

Inverting a lens model takes Newton steps for every pixel. Directions are smooth, so cubic interpolation
between nodes a third of a degree apart reproduces them to about 1e-6 px. Pixels near directions that the lens
does not see are computed exactly.
"""

import numpy as np
from scipy.sparse import csr_array

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model import Camera

_STEP_RAD = 0.006  # between nodes
_WIDEST_PX = 16  # greatest distance between nodes


class RayGrid:
    """The directions of a camera's pixels, NaN where it sees nothing.

    angle   rad per pixel in the middle of the picture
    """

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        middle = np.array([camera.width, camera.height]) / 2
        near = camera.ray(middle + np.array([[0.5, 0.0], [-0.5, 0.0]]))
        self.angle = float(np.linalg.norm(near[1] - near[0]))
        step = min(max(_STEP_RAD / self.angle, 1.0), _WIDEST_PX)
        self._x, self._y = _nodes(camera.width, step), _nodes(camera.height, step)
        x, y = np.meshgrid(self._x, self._y)
        exact = camera.ray(np.column_stack([x.ravel(), y.ravel()]))
        self._exact = exact.reshape(len(self._y), len(self._x), 3)
        self._across = _weights(self._x, np.arange(camera.width) + 0.5)

    def rows(self, first: int, end: int) -> Float:
        """Return unit directions (end - first, width, 3), camera frame, of pixel centres in some rows.

        The rows are `first` to `end` - 1.
        """
        y = np.arange(first, end) + 0.5
        down = _weights(self._y, y)
        # a node without direction must not affect pixels in which it has no weight
        known = finite(self._exact)
        nodes = np.where(known[..., None], self._exact, 0.0)
        seen = self._spread(down, known[..., None].astype(np.float64))[..., 0] > 1 - 1e-9
        rays = self._spread(down, nodes)
        rays /= np.maximum(np.linalg.norm(rays, axis=2, keepdims=True), 1e-12)
        if not known.all():
            touched = self._spread(abs(down), (~known[..., None]).astype(np.float64), abs(self._across))
            row, column = np.nonzero((touched[..., 0] > 1e-12) | ~seen)
            rays[row, column] = self.camera.ray(np.column_stack([column + 0.5, y[row]]))
        return rays

    def _spread(self, down: csr_array, nodes: Float, across: csr_array | None = None) -> Float:
        """Interpolates node values (a, b, k) at pixels: (rows, width, k)."""
        a, b, k = nodes.shape
        rows = np.asarray(down @ nodes.reshape(a, b * k)).reshape(-1, b, k)
        turned = np.ascontiguousarray(rows.transpose(1, 0, 2)).reshape(b, -1)
        wide = np.asarray((self._across if across is None else across) @ turned)
        return np.ascontiguousarray(wide.reshape(-1, len(rows), k).transpose(1, 0, 2))


def finite(rays: Float) -> Bool:
    """Return which directions (..., 3) are known."""
    return np.asarray(np.isfinite(rays[..., 0]) & np.isfinite(rays[..., 2]))


def _nodes(size: int, step: float) -> Float:
    return np.linspace(0.0, size, max(4, int(np.ceil(size / step)) + 1))


def _weights(nodes: Float, at: Array) -> csr_array:
    """Returns Lagrange's cubic weights (n, nodes) of the four equidistant nodes around positions (n,)."""
    step = nodes[1] - nodes[0]
    first = np.clip(np.floor(at / step).astype(np.int64) - 1, 0, len(nodes) - 4)
    t = at / step - first
    w = np.column_stack(
        [
            -(t - 1) * (t - 2) * (t - 3) / 6,
            t * (t - 2) * (t - 3) / 2,
            -t * (t - 1) * (t - 3) / 2,
            t * (t - 1) * (t - 2) / 6,
        ]
    )
    columns = first[:, None] + np.arange(4)
    return csr_array((w.ravel(), columns.ravel(), np.arange(0, 4 * len(at) + 1, 4)), (len(at), len(nodes)))
