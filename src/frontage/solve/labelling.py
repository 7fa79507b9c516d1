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
_ROWS, _COLUMNS = 64, 128  # of cells that are labelled at once; even
_AROUND = 4  # cells that messages reach in the last steps, at most; even
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

    A message goes one cell per step, so that windows of cells with some around them are labelled as the
    whole would be. A window stays in the cache, and its memory is used again by the next one.
    """
    _, h, w = cost.shape
    inherits = messages.shape[2:] != (h, w)
    out = np.empty((h, w), np.int64)
    for row in range(0, h, _ROWS):
        for column in range(0, w, _COLUMNS):
            (top, bottom), (left, right) = _span(row, _ROWS, h), _span(column, _COLUMNS, w)
            part = np.s_[:, top:bottom, left:right]
            if inherits:
                halves = messages[:, :, top // 2 : -(-bottom // 2), left // 2 : -(-right // 2)]
                own = _doubled(halves, bottom - top, right - left)
            else:
                own = messages[:, *part].copy()
            belief = _sent(cost[part], base, border[part], own, _LAST_STEPS)
            inner = belief[:, row - top :, column - left :][:, :_ROWS, :_COLUMNS]
            out[row : row + _ROWS, column : column + _COLUMNS] = np.argmin(inner, axis=0)
    return out


def _span(first: int, count: int, size: int) -> tuple[int, int]:
    """The first and last (excluded) of `size` cells that labels of `count` cells depend on."""
    return max(first - _AROUND, 0), min(first + count + _AROUND, size)


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
    belief = cost + messages[0]
    for message in messages[1:]:
        belief += message
    edges = [np.add(border[ahead], border[behind]) for ahead, behind in (_slices(1, 1), _slices(2, 1))]
    spare = [(np.empty_like(edge), np.empty_like(edge), np.empty_like(edge[0])) for edge in edges]
    for _ in range(steps):
        for d, (axis, step) in enumerate(_AXES):
            ahead, behind = _slices(axis, step)
            sent, back, there = messages[d][ahead], messages[d ^ 1][behind], belief[ahead]
            least = _told(belief[behind], back, edges[axis - 1], base, spare[axis - 1])
            there -= sent
            np.minimum(*spare[axis - 1][:2], out=sent)
            sent -= least
            there += sent
    return np.asarray(belief)


def _told(
    belief: Array, back: Array, edge: Array, base: np.float32, spare: tuple[Array, Array, Array]
) -> Array:
    """What cells tell their neighbours: the lesser of two arrays, less what is returned (m, n).

    The arrays are the first two of the spare ones, in which only memory is used again. `belief` (k, m, n) is
    that of the senders, `back` (k, m, n) what they were told by the receivers, and `edge` (k, m, n) what a
    border between the two costs on top of `base`.
    """
    own, other, least = spare
    np.subtract(belief, back, out=own)  # without what came from the receiver
    np.add(own, edge, out=other)
    _least(other, least)
    least += base
    np.add(edge, least, out=other)
    _least(own, least)  # no way through another label is cheaper than that
    return least


def _least(values: Array, out: Array) -> None:
    """Writes the least of values (k, m, n) along their first axis to `out` (m, n)."""
    np.copyto(out, values[0])
    for plane in values[1:]:
        np.minimum(out, plane, out=out)


def _slices(axis: int, step: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """The cells that receive along an axis, and those that send to them."""
    every = [slice(None)] * 3
    low, high = list(every), list(every)
    low[axis], high[axis] = slice(None, -1), slice(1, None)
    return (tuple(high), tuple(low)) if step > 0 else (tuple(low), tuple(high))
