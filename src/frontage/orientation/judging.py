"""Which adjusted photos may stay: what supports the pose of each, and what contradicts it."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Bool, Int
from frontage.orientation.adjusted import AdjustedPhotos
from frontage.orientation.result import Unoriented
from frontage.orientation.verify import Verdict

_FEWEST_CONTROL = 12
_FEWEST_TIES = 30
_CONFIRMING = 50  # control points, each of which stands out from chance and agrees with the others


def judged(
    state: AdjustedPhotos, verdicts: Sequence[Verdict], contrary: Sequence[bool], *, last: bool
) -> tuple[Int, list[Unoriented]]:
    """Returns which photos may stay, and why the others may not.

    Poses that are `contrary` to the approximate ones need many control points of their own. Tie points do
    not help there: those between different things that look alike agree with one another. Doubts count in
    the `last` judgement only: until then a photo may get tie points with its neighbours.
    """
    keep, refused = [], list[Unoriented]()
    recognising = _recognising(state)
    of_block = _sums_of_blocks(state, recognising)
    doubted = np.array([verdict.doubted for verdict in verdicts], bool)
    sure = ~doubted & (recognising >= _CONFIRMING)
    known = _with_tied(state, sure, ~doubted & ~np.array(contrary, bool))
    for k, (photo, verdict) in enumerate(zip(state.placed.photos, verdicts, strict=True)):
        # What the other cameras of its rig see supports a photo as well as what it sees itself.
        fellows = state.fellows(k)
        control, ties = int(recognising[fellows].sum()), sum(len(state.ties_of(j)) for j in fellows)
        held = not last or not verdict.doubted or _ties_to(state, k, known) >= _FEWEST_TIES
        if verdict.contradicted or not held:
            text = f"the scan is found {verdict.distance} from where its pose puts it"
            refused.append(Unoriented(photo.id, "O104", text))
        elif contrary[k] and not sure[k]:
            text = "its pose contradicts the approximate one, and too few control points support it"
            refused.append(Unoriented(photo.id, "O104", text))
        elif control < _FEWEST_CONTROL and ties < _FEWEST_TIES:
            text = f"only {control} control points and {ties} tie points support its pose"
            refused.append(Unoriented(photo.id, "O105", text))
        elif of_block[k] < _FEWEST_CONTROL:
            text = f"only {of_block[k]} control points support it together with the photos that it is tied to"
            refused.append(Unoriented(photo.id, "O105", text))
        else:
            keep.append(k)
    return np.array(keep, np.int64), refused


def _with_tied(state: AdjustedPhotos, sure: Bool, others: Bool) -> Bool:
    """The sure photos (p,), and those of the others that many tie points connect with them, step by step."""
    known = sure.copy()
    while True:
        waiting = np.flatnonzero(others & ~known)
        new = [k for k in waiting.tolist() if _ties_to(state, k, known) >= _FEWEST_TIES]
        if not new:
            return known
        known[new] = True


def _ties_to(state: AdjustedPhotos, photo: int, others: Bool) -> int:
    """How many tie points of a photo are seen by any of the `others`, a mask (p,) of the photos."""
    images = state.network.images
    seen = images.point[state.ties & others[images.photo]]
    return int(np.isin(images.point[state.ties_of(photo)], seen).sum())


def _recognising(state: AdjustedPhotos) -> Int:
    """How many control points (p,) of every photo show that it is where it is thought to be."""
    return np.array([state.recognising(k) for k in range(len(state.placed.photos))], np.int64)


def _sums_of_blocks(state: AdjustedPhotos, counts: Int) -> Int:
    """The sum (p,) of counts (p,) over all photos of the block of every photo."""
    block = state.blocks
    return np.asarray(np.bincount(block, counts)[block], np.int64)


def in_one_word(state: AdjustedPhotos, photo: int, verdict: Verdict) -> str:
    """What supports a pose: the scan, other photos ("tied"), its rig ("carried"), or little ("plain")."""
    control = state.recognising(photo)
    if verdict.confirmed or (control >= _CONFIRMING and verdict.alone):
        return "confirmed"
    if len(state.ties_of(photo)) >= _FEWEST_TIES:
        return "tied"
    return "carried" if control < _FEWEST_CONTROL and len(state.fellows(photo)) > 1 else "plain"
