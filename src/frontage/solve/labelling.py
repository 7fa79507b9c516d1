"""Labels on a grid: the assignment of least energy, by min-sum belief propagation from coarse to fine.

The energy is a cost per cell and label plus, on every border between neighbours of different labels a and b,
``base + e_a + e_b``, where e is what a border costs on the side of each label. That cost is a metric (a way
through a third label is never cheaper), and a message is computed in O(labels). Messages run on blocks of
cells first, whose costs are sums over their cells (Felzenszwalb and Huttenlocher, Efficient belief
propagation for early vision, IJCV 2006). The number of steps is fixed, so that the time is bounded,
and the result does not depend on how many processes are at work.
"""

import numpy as np

from frontage.geometry.arrays import Array, Int

_LEVELS = 6  # the coarsest blocks are 32 x 32 cells
_STEPS = 6  # of messages per level
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
    for level in range(len(costs) - 1, -1, -1):
        h, w = costs[level].shape[1:]
        if messages.shape[2:] != (h, w):
            messages = messages.repeat(2, axis=2).repeat(2, axis=3)[:, :, :h, :w] * np.float32(0.5)
        for _ in range(_STEPS):
            messages = _passed(costs[level], np.float32(base * 2**level), borders[level], messages)
    return np.asarray(np.argmin(cost + messages.sum(0), axis=0), np.int64)


def _halved(values: Array) -> Array:
    """Sums blocks of 2 x 2 cells of values (k, h, w); beyond the border there is nothing."""
    k, h, w = values.shape
    padded = np.pad(values, ((0, 0), (0, h % 2), (0, w % 2)))
    total: Array = padded.reshape(k, -(-h // 2), 2, -(-w // 2), 2).sum(axis=(2, 4))
    return total


def _passed(cost: Array, base: np.float32, border: Array, messages: Array) -> Array:
    """Sends all messages (4, k, h, w) once; message d reached its cell along `_AXES[d]`."""
    belief = cost + messages.sum(0)
    sent = np.zeros_like(messages)
    for d, (axis, step) in enumerate(_AXES):
        ahead, behind = _slices(axis, step)
        own = belief[behind] - messages[d ^ 1][behind]  # without what came from the receiver
        edge = border[behind] + border[ahead]
        message = np.minimum(own, edge + ((own + edge).min(0) + base))
        sent[d][ahead] = message - message.min(0, keepdims=True)
    return sent


def _slices(axis: int, step: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """The cells that receive along an axis, and those that send to them."""
    every = [slice(None)] * 3
    low, high = list(every), list(every)
    low[axis], high[axis] = slice(None, -1), slice(1, None)
    return (tuple(high), tuple(low)) if step > 0 else (tuple(low), tuple(high))
