"""Labels on a grid: the assignment of least energy, by min-sum belief propagation from coarse to fine.

The energy is a cost per cell and label plus, on every border between neighbours of different labels a and b,
``base + e_a + e_b``, where e is what a border costs on the side of each label. That cost is a metric (a way
through a third label is never cheaper), and a message is computed in O(labels). Messages run on blocks of
cells first, whose costs are sums over their cells (Felzenszwalb and Huttenlocher, Efficient belief
propagation for early vision, IJCV 2006). Each direction uses what the ones before it have sent in the same
step, and single cells, which inherit what their blocks agreed on, need fewer steps. The number of steps is
fixed, so that the time is bounded, and the result does not depend on how many processes are at work.
"""

import numpy as np

from frontage.geometry.arrays import Array, Int

_LEVELS = 6  # the coarsest blocks are 32 x 32 cells
_STEPS = 6  # of messages per level of blocks
_LAST_STEPS = 3  # of messages between single cells
_STRIP = 64  # rows of cells that are labelled at once; even
_AROUND = 4  # rows of cells that messages reach in the last steps, at most; even
_AXES = ((1, 1), (1, -1), (2, 1), (2, -1))  # axis and step from the sender to the receiver


def label_grid(cost: Array, base: float, border: Array) -> Int:
    """Returns the labels (h, w) of least energy.

    `cost` (k, h, w) float32 is that of every label, and `border` (k, h, w) float32 >= 0 what a border with
    another label costs at a cell; between two neighbours it counts half of each.
    """
    costs, borders = [cost], [0.5 * border]
    while len(costs) < _LEVELS and min(costs[-1].shape[1:]) > 1:
        costs.append(_halved(costs[-1]))
        borders.append(_halved(borders[-1]) * np.float32(0.5))
    messages = np.zeros((4, *costs[-1].shape), np.float32)
    for level in range(len(costs) - 1, 0, -1):
        h, w = costs[level].shape[1:]
        if messages.shape[2:] != (h, w):
            messages = _doubled(messages, h, w)
        _sent(costs[level], np.float32(base * 2**level), borders[level], messages, _STEPS)
    return _labels_of_cells(cost, np.float32(base), borders[0], messages)


def _labels_of_cells(cost: Array, base: np.float32, border: Array, messages: Array) -> Int:
    """Labels the single cells (k, h, w), which inherit the messages of their blocks.

    A message goes one cell per step, so that strips of cells with some rows around them are labelled as the
    whole would be. A strip stays in the cache, and its memory is used again by the next one.
    """
    _, h, w = cost.shape
    inherits = messages.shape[2:] != (h, w)

    def labels(first: int) -> Int:
        top, last = max(first - _AROUND, 0), min(first + _STRIP, h)
        rows = slice(top, min(last + _AROUND, h))
        own = messages[:, :, rows].copy()
        if inherits:
            own = _doubled(messages[:, :, top // 2 : -(-rows.stop // 2)], rows.stop - top, w)
        belief = _sent(cost[:, rows], base, border[:, rows], own, _LAST_STEPS)
        return np.asarray(np.argmin(belief[:, first - top : last - top], axis=0), np.int64)

    return np.concatenate([labels(first) for first in range(0, h, _STRIP)])


def _halved(values: Array) -> Array:
    """Sums blocks of 2 x 2 cells of values (k, h, w); beyond the border there is nothing."""
    _, h, w = values.shape
    padded = np.pad(values, ((0, 0), (0, h % 2), (0, w % 2)))
    rows = padded[:, ::2] + padded[:, 1::2]
    return np.asarray(rows[..., ::2] + rows[..., 1::2])


def _doubled(values: Array, h: int, w: int) -> Array:
    """Halves the messages (4, k, ...) of blocks, and gives them to the 2 x 2 cells of each, h x w in all."""
    out = np.empty((*values.shape[:2], h, w), values.dtype)
    for row in (0, 1):
        for column in (0, 1):
            part = out[:, :, row::2, column::2]
            np.multiply(values[:, :, : part.shape[2], : part.shape[3]], np.float32(0.5), out=part)
    return out


def _sent(cost: Array, base: np.float32, border: Array, messages: Array, steps: int) -> Array:
    """Sends all messages (4, k, h, w) some times, in place; returns the belief (k, h, w)."""
    belief = cost + messages.sum(0)
    for _ in range(steps):
        _pass(belief, base, border, messages)
    return np.asarray(belief)


def _pass(belief: Array, base: np.float32, border: Array, messages: Array) -> None:
    """Sends all messages (4, k, h, w) once, one direction after the other, and updates them in place.

    Message d reached its cell along `_AXES[d]`; the belief (k, h, w) is the cost plus all messages.
    """
    for d, (axis, step) in enumerate(_AXES):
        ahead, behind = _slices(axis, step)
        own = belief[behind] - messages[d ^ 1][behind]  # without what came from the receiver
        edge = border[behind] + border[ahead]
        edge += np.add(own, edge).min(0) + base
        message = np.minimum(own, edge, out=own)
        message -= message.min(0, keepdims=True)
        belief[ahead] += np.subtract(message, messages[d][ahead], out=edge)
        messages[d][ahead] = message


def _slices(axis: int, step: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """The cells that receive along an axis, and those that send to them."""
    every = [slice(None)] * 3
    low, high = list(every), list(every)
    low[axis], high[axis] = slice(None, -1), slice(1, None)
    return (tuple(high), tuple(low)) if step > 0 else (tuple(low), tuple(high))
