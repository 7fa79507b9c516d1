"""What is measured on a mosaic: seams, ghosts, occluders, coverage, colours, places."""

import cv2
import numpy as np

from _mosaics import SeenWall, Single
from frontage.geometry.arrays import Array, Bool, Float

SIDE = 4  # px on either side of a line whose mean colours are compared
BESIDE = range(5, 11)  # px from a seam: the parallel lines that it is compared with
TILE = 64  # px
TEXTURE = 0.04  # standard deviation of the detail of a tile that shows something


def figures(pixels: Array, source: Array, singles: list[Single], truth: SeenWall) -> dict[str, float]:
    """All figures of one mosaic; `source` (h, w) is 1 + the number of the photo, 0 = empty, -1 = several.

    `singles` is every photo alone.
    """
    known = source != 0
    sure = _from_clear(source, truth)
    step, edge = seam_excess(pixels, source)
    sharpness, likeness = ghosting(pixels, known, singles, truth)
    return {
        "step": step,
        "edge": edge,
        "sharp": sharpness,
        "alike": likeness,
        "occluder": painted_behind(source, truth),
        "wall": covered(known, truth.wall, truth),
        "glass": covered(known, truth.glass, truth),
        "colour": colour_difference(pixels, known & truth.wall & sure, truth.rgb),
        "shift": displacement(pixels, known & truth.wall, truth.rgb),
    }


def seam_excess(pixels: Array, source: Array) -> tuple[float, float]:
    """Across seams against the lines 5 to 10 px beside: step of mean colours, and step from pixel to pixel.

    Both in units of CIE Lab, as the mean over all seams less the mean over the lines; NaN without a seam.
    """
    lab = cv2.cvtColor(np.ascontiguousarray(pixels[..., :3]).astype(np.float32) / 255.0, cv2.COLOR_RGB2Lab)
    steps, edges, rest_steps, rest_edges = [], [], [], []
    for flip in (False, True):
        image, label = (lab.transpose(1, 0, 2), source.T) if flip else (lab, source)
        step, edge = _across(image)
        left, right = label[:, :-1], label[:, 1:]
        apart = _alone(label)
        seam = (left != right) & (left > 0) & (right > 0) & apart
        rows, columns = np.nonzero(seam)
        steps.append(step[rows, columns])
        edges.append(edge[rows, columns])
        for d in [s * b for b in BESIDE for s in (-1, 1)]:
            at = columns + d
            inside = (at >= 0) & (at < step.shape[1])
            r, c = rows[inside], at[inside]
            same = (left[r, c] == right[r, c]) & (left[r, c] > 0) & apart[r, c]
            rest_steps.append(step[r[same], c[same]])
            rest_edges.append(edge[r[same], c[same]])
    if not sum(map(len, steps)) or not sum(map(len, rest_steps)):
        return float("nan"), float("nan")
    mean = [float(np.mean(np.concatenate(v))) for v in (steps, rest_steps, edges, rest_edges)]
    return mean[0] - mean[1], mean[2] - mean[3]


def _across(lab: Array) -> tuple[Float, Float]:
    """Colour differences (h, w - 1) across column c and c + 1: of means over `SIDE` px, of pixels."""
    mean = cv2.blur(lab, (SIDE, 1), anchor=(SIDE - 1, 0))  # of the SIDE px up to and with a column
    ahead = np.roll(mean, -SIDE, axis=1)
    return (
        np.linalg.norm(ahead - mean, axis=2)[:, :-1],
        np.linalg.norm(np.diff(lab, axis=1), axis=2),
    )


def _alone(label: Array) -> Bool:
    """Where (h, w - 1) the `SIDE` px on either side of a line between columns come from one photo each."""
    change = np.zeros((label.shape[0], label.shape[1] + 2 * SIDE), np.float32)
    change[:, SIDE : SIDE + label.shape[1] - 1] = label[:, :-1] != label[:, 1:]
    change[:, :SIDE] = change[:, SIDE + label.shape[1] - 1 :] = 1.0
    total = cv2.boxFilter(change, -1, (2 * SIDE - 1, 1), normalize=False)
    return np.asarray((total - change < 0.5)[:, SIDE : SIDE + label.shape[1] - 1])


def ghosting(pixels: Array, known: Bool, singles: list[Single], truth: SeenWall) -> tuple[float, float]:
    """Medians over tiles: sharpness against the best single photo, and correlation with the likest one.

    Single photos count where they see the whole tile with nothing in between; the sharpest is the best.
    """
    mine = _detail(pixels)
    photos = [
        (_detail(one.pixels), one.shown & _upsampled(c, one.shown.shape))
        for one, c in zip(singles, truth.clear, strict=True)
    ]
    sharp, alike = [], []
    for r in range(0, mine.shape[0] - TILE + 1, TILE):
        for c in range(0, mine.shape[1] - TILE + 1, TILE):
            s = np.s_[r : r + TILE, c : c + TILE]
            fair = [p[s] for p, shown in photos if shown[s].mean() > 0.98]
            fair = [p for p in fair if p.std() > TEXTURE]
            if not fair or known[s].mean() < 0.98:
                continue
            own = mine[s] / max(float(mine[s].std()), 1e-6)
            sharp.append(mine[s].std() / max(p.std() for p in fair))
            alike.append(max(float((own * (p - p.mean())).mean() / p.std()) for p in fair))
    return (float(np.median(sharp)), float(np.median(alike))) if sharp else (float("nan"),) * 2


def _detail(pixels: Array) -> Array:
    """Fine detail (h, w) relative to the light around it, so that neither exposure nor shadow counts."""
    grey = cv2.cvtColor(np.ascontiguousarray(pixels[..., :3]), cv2.COLOR_RGB2GRAY)
    light = (grey / np.float32(255.0)) ** 2.2 + np.float32(0.01)
    return np.log(light) - cv2.GaussianBlur(np.log(light), (0, 0), 6.0)


def _upsampled(sampled: Bool, shape: tuple[int, int]) -> Bool:
    return cv2.resize(sampled.astype(np.uint8), shape[::-1], interpolation=cv2.INTER_NEAREST) > 0


def _sampled(band: Array, truth: SeenWall) -> Array:
    return band[np.ix_(*truth.at)]


def _from_clear(source: Array, truth: SeenWall) -> Bool:
    """The pixels (h, w) whose photo sees the wall there; all of those that mix several photos."""
    chosen = np.maximum(_sampled(source, truth).astype(np.int64) - 1, 0)
    clear = np.take_along_axis(truth.clear, chosen[None], 0)[0] | (_sampled(source, truth) < 0)
    return _upsampled(clear, source.shape)


def painted_behind(source: Array, truth: SeenWall) -> float:
    """The share of the painted facade that shows what stands before it; several photos: their share."""
    label, shown = _sampled(source, truth).astype(np.int64), _sampled(truth.wall | truth.glass, truth)
    hidden = np.take_along_axis(truth.behind, np.maximum(label - 1, 0)[None], 0)[0].astype(float)
    seen = truth.behind | truth.clear
    mixed = truth.behind.sum(0) / np.maximum(seen.sum(0), 1)
    return float(np.where(label < 0, mixed, hidden)[shown & (label != 0)].mean())


def covered(known: Bool, what: Bool, truth: SeenWall) -> float:
    """The share of what at least one photo sees that is painted."""
    seen = truth.clear.any(0) & _sampled(what, truth)
    return float(_sampled(known, truth)[seen].mean()) if seen.any() else float("nan")


def colour_difference(pixels: Array, where: Bool, rgb: Array) -> float:
    """Mean difference of colour (CIE Lab) to the truth after one gain per channel, at 5 cm or so."""
    mine, true = (cv2.blur((p[..., :3].astype(np.float32) / 255.0) ** 2.2, (5, 5)) for p in (pixels, rgb))
    where = cv2.erode(where.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    ratio = np.log(np.maximum(true[where], 1e-3)) - np.log(np.maximum(mine[where], 1e-3))
    mine = mine * np.exp(np.median(ratio, axis=0)).astype(np.float32)
    lab = [cv2.cvtColor(np.clip(p, 0, 1) ** (1 / 2.2), cv2.COLOR_RGB2Lab)[where] for p in (mine, true)]
    return float(np.linalg.norm(lab[0] - lab[1], axis=1).mean())


def displacement(pixels: Array, where: Bool, rgb: Array) -> float:
    """Median shift (px) of tiles against the truth, of tiles that correlate with it."""
    mine, true, shifts = _detail(pixels), _detail(rgb), []
    window = cv2.createHanningWindow((TILE, TILE), cv2.CV_32F)
    for r in range(0, mine.shape[0] - TILE + 1, TILE // 2):
        for c in range(0, mine.shape[1] - TILE + 1, TILE // 2):
            s = np.s_[r : r + TILE, c : c + TILE]
            if where[s].mean() < 0.9 or true[s].std() < TEXTURE:
                continue
            move, response = cv2.phaseCorrelate(true[s] * window, mine[s] * window)
            if response > 0.3:
                shifts.append(float(np.hypot(*move)))
    return float(np.median(shifts)) if shifts else float("nan")
