"""Labels on a grid: the assignment of least energy, by min-sum belief propagation from coarse to fine.

The energy is a cost per cell and label plus, on every border between neighbours of different labels a and b,
``base + e_a + e_b``, where e is what a border costs on the side of each label. That cost is a metric (a way
through a third label is never cheaper), and a message is computed in O(labels). Messages run on blocks of
cells first, whose costs are sums over their cells (Felzenszwalb and Huttenlocher, Efficient belief
propagation for early vision, IJCV 2006). Each direction uses what the ones before it have sent in the same
step, and single cells, which inherit what their blocks agreed on, need fewer steps. The number of steps is
fixed, so that the time is bounded, and the result does not depend on how many processes are at work.

Energies are whole numbers of two bytes, of which `base` has 256: processors add and compare twice as many of
them at once. What a label costs beyond the cheapest one of a cell counts up to `_MOST`, more than all borders
around the cell. On the next larger blocks, whose borders are twice as long, the unit is twice as large, so
that messages are the same numbers there.
"""

import numpy as np

from frontage.geometry.arrays import Array, Int

_BASE = np.int16(256)
_MOST = 12800  # what a label may cost beyond the cheapest one, 50 times `base`
_MOST_BORDER = 1000  # half of what a border may cost on one side; no sum exceeds two bytes
_LEVELS = 6  # the coarsest blocks are 32 x 32 cells
_STEPS = 6  # of messages per level of blocks
_LAST_STEPS = 3  # of messages between single cells
_ROWS, _COLUMNS = 64, 256  # of cells that are labelled at once; even
_AROUND = 4  # cells that messages reach in the last steps, at most; even
_AXES = ((1, 1), (1, -1), (2, 1), (2, -1))  # axis and step from the sender to the receiver


def label_grid(cost: Array, base: float, border: Array) -> Int:
    """Returns the labels (h, w) of least energy.

    `cost` (k, h, w) float32 is that of every label, and `border` (k, h, w) float32 >= 0 what a border with
    another label costs at a cell; between two neighbours it counts half of each.
    """
    scale = np.float32(float(_BASE) / base)
    costs, borders = [cost * scale], [(0.5 * scale) * border]
    while len(costs) < _LEVELS and min(costs[-1].shape[1:]) > 1:
        costs.append(_halved(costs[-1]) * np.float32(0.5))
        borders.append(_halved(borders[-1]) * np.float32(0.25))
    messages = np.zeros((4, *costs[-1].shape), np.int16)
    for level in range(len(costs) - 1, 0, -1):
        h, w = costs[level].shape[1:]
        if messages.shape[2:] != (h, w):
            messages = _doubled(messages, h, w)
        _sent(_whole(costs[level]), _limited(borders[level]), messages, _STEPS)
    label = _labels_of_cells(_whole(costs[0]), _limited(borders[0]), messages)
    _join_lone_cells(label, cost, np.float32(base), np.float32(0.5) * border)
    return label


def _join_lone_cells(label: Int, cost: Array, base: np.float32, half: Array) -> None:
    """Gives cells whose four neighbours have other labels (h, w) one of those where it has less energy.

    Messages that went round in circles leave some. `cost` (k, h, w) is that of the labels, and `half`
    (k, h, w) what they add to a border on their side.
    """
    h, w = label.shape
    around = np.pad(label, 1, constant_values=-1)
    beside = around[:-2, 1:-1], around[2:, 1:-1], around[1:-1, :-2], around[1:-1, 2:]
    at = np.flatnonzero(np.all([other != label for other in beside], axis=0))
    rows, columns = np.divmod(at, w)
    near = np.stack(
        [at - w * (rows > 0), at + w * (rows < h - 1), at - (columns > 0), at + (columns < w - 1)]
    )
    costs, halves, labels = cost.reshape(len(cost), -1), half.reshape(len(half), -1), label.reshape(-1)
    theirs, found = labels[near], labels[at]
    added, least = base + halves[theirs, near], np.full(len(at), np.inf, np.float32)
    for other in (found.copy(), *theirs):
        borders = (theirs != other) & (near != at)
        energy = costs[other, at] + (borders * (added + halves[other, at])).sum(0)
        better = energy < least
        least[better], found[better] = energy[better], other[better]
    labels[at] = found


def _whole(cost: Array) -> Array:
    """Returns by how much costs (k, h, w) exceed the least one of their cell: whole numbers up to `_MOST`."""
    beyond = cost - cost.min(0)
    return np.asarray(np.minimum(beyond, np.float32(_MOST), out=beyond), np.int16)


def _limited(border: Array) -> Array:
    """Returns costs of borders as whole numbers up to `_MOST_BORDER`."""
    return np.minimum(border, np.float32(_MOST_BORDER)).astype(np.int16)


def _labels_of_cells(cost: Array, border: Array, messages: Array) -> Int:
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
            belief = _sent(cost[part], border[part], own, _LAST_STEPS)
            inner = belief[:, row - top :, column - left :][:, :_ROWS, :_COLUMNS]
            _write_least(inner, out[row : row + _ROWS, column : column + _COLUMNS])
    return out


def _write_least(belief: Array, out: Int) -> None:
    """Writes to `out` (m, n) which of k labels has the least belief (k, m, n); of equal ones the first.

    Plane after plane, this takes a third of the time of `numpy.argmin`.
    """
    least = belief[0].copy()
    out[:] = 0
    for label, plane in enumerate(belief[1:], 1):
        np.copyto(out, label, where=plane < least)
        np.minimum(least, plane, out=least)


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
    """Gives the messages (4, k, ...) of blocks to the 2 x 2 cells of each, h x w in all."""
    out = np.empty((*values.shape[:2], h, w), values.dtype)
    for row in (0, 1):
        for column in (0, 1):
            part = out[:, :, row::2, column::2]
            part[:] = values[:, :, : part.shape[2], : part.shape[3]]
    return out


def _sent(cost: Array, border: Array, messages: Array, steps: int) -> Array:
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
            least = _told(belief[behind], back, edges[axis - 1], spare[axis - 1])
            there -= sent
            np.minimum(*spare[axis - 1][:2], out=sent)
            sent -= least
            there += sent
    return np.asarray(belief)


def _told(belief: Array, back: Array, edge: Array, spare: tuple[Array, Array, Array]) -> Array:
    """What cells tell their neighbours: the lesser of two arrays, less what is returned (m, n).

    The arrays are the first two of the spare ones, in which only memory is used again. `belief` (k, m, n) is
    that of the senders, `back` (k, m, n) what they were told by the receivers, and `edge` (k, m, n) what a
    border between the two costs on top of `_BASE`.
    """
    own, other, least = spare
    np.subtract(belief, back, out=own)  # without what came from the receiver
    np.add(own, edge, out=other)
    _least(other, least)
    least += _BASE
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
