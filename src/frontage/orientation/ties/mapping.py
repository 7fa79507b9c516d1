"""From matched pairs to blocks of oriented photos with tie points.

Pairs that contradict the others, and those that a shift by one window explains as well, are left out; the
rest goes through incremental mapping. Doubtful pairs may then add the photos that are left. Every photo of a
block is tested for a shift; those that fit two places and whose approximate pose does not decide are taken
out. The final adjustment uses tracks that three photos confirm.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from frontage.model import Photo
from frontage.orientation.nouns import Block, CommonPoints, KeyPoints, PairMatches
from frontage.orientation.ties import colmap as door
from frontage.orientation.ties import reasons
from frontage.orientation.ties.consistency import consistent
from frontage.orientation.ties.mapper import run_mapper, to_block
from frontage.orientation.ties.options import TieOptions
from frontage.orientation.ties.polish import confirmed, polish, without
from frontage.orientation.ties.poses import contradicts, settles
from frontage.orientation.ties.two import block_of_two
from frontage.orientation.ties.verify import doubts

_LEAST_POINTS = 20  # tie points of a photo that others confirm
_ENOUGH = 0.5  # of the photos of all pairs that get a place: no other start is tried
_STRONG = 100  # with as many the approximate pose is not asked, which may be wrong itself


@dataclass(frozen=True, eq=False)
class Blocks:
    """The blocks of photos, the largest first, and the photos in none of them with the reason.

    unoriented  (photo id, one sentence)
    common      of all pairs that no shift explains, also of those between blocks
    """

    blocks: tuple[Block, ...]
    unoriented: tuple[tuple[str, str], ...]
    common: tuple[CommonPoints, ...] = ()


def build_blocks(
    photos: Sequence[Photo],
    keypoints: Sequence[KeyPoints],
    pairs: Sequence[PairMatches],
    options: TieOptions | None = None,
) -> Blocks:
    """Orients photos relative to one another.

    photos     with approximate poses, or without; cameras are kept unless `options.self_calibrate`
    keypoints  of every photo
    pairs      from `match_pair`, with numbers of `photos`

    Every photo is either in exactly one block or listed with a reason. Poses of a block have covariances of
    NaN, which the adjustment that follows estimates. Raises MissingExtra without pycolmap.
    """
    options = options or TieOptions()
    why: dict[int, str] = {}
    for copy, original in reasons.duplicates(photos, keypoints, pairs).items():
        why[copy] = reasons.copy_of(photos[original].id)
    usable = [p for p in pairs if p.first not in why and p.second not in why]
    usable = sorted(usable, key=lambda p: (p.first, p.second))
    with door.silent() as colmap:
        work = _Work(colmap, photos, keypoints, options, why)
        blocks = work.blocks(usable)
    common = tuple(CommonPoints.of(pair, keypoints) for pair in work.clear(usable))
    blocks.sort(key=lambda b: (-len(b.photos), -len(b.points), int(b.numbers[0])))
    placed = {int(n) for b in blocks for n in b.numbers}
    left = []
    for k, photo in enumerate(photos):
        if k not in placed:
            left.append((photo.id, why.get(k) or reasons.reason(k, photos, keypoints, pairs, options)))
    return Blocks(tuple(blocks), tuple(left), common)


@dataclass(frozen=True, eq=False)
class _Work:
    """One call of `build_blocks`; `why` collects the reasons of photos that are left out."""

    colmap: Any
    photos: Sequence[Photo]
    keypoints: Sequence[KeyPoints]
    options: TieOptions
    why: dict[int, str]

    def clear(self, pairs: list[PairMatches]) -> list[PairMatches]:
        """The pairs that no shift by a window explains as well, and that do not contradict the others."""
        return consistent([p for p in pairs if p.rival <= self.options.rival], self.photos, self.options)

    def blocks(self, pairs: list[PairMatches]) -> list[Block]:
        """Blocks that share no photo, from the clear pairs.

        Doubtful pairs may add photos that are left and have approximate poses, which then must agree.
        """
        clear = self.clear(pairs)
        made = self._blocks_of(clear)
        placed = {int(n) for b in made for n in b.numbers}
        open_ = {n for n, photo in enumerate(self.photos) if photo.local_from_camera is not None} - placed
        doubtful = [p for p in pairs if p.rival > self.options.rival and {p.first, p.second} & open_]
        if doubtful:
            more = self._blocks_of(consistent([*clear, *doubtful], self.photos, self.options))
            if sum(len(b.photos) for b in more) > len(placed):
                made = more
        return made or self._two(clear)

    def _blocks_of(self, pairs: list[PairMatches]) -> list[Block]:
        """The blocks of the first start that gives most photos a place, or else of the best one.

        A start from two photos whose matches are mostly false leaves nothing that other photos confirm.
        """
        before = dict(self.why)
        best, most, why = list[Block](), -1, before
        enough = _ENOUGH * len({n for p in pairs for n in (p.first, p.second)})
        for models in run_mapper(self.colmap, self.photos, self.keypoints, pairs, self.options):
            self._restart(before)
            made = list[Block]()
            for model in models:
                self._add(made, model)
            count = sum(len(block.photos) for block in made)
            if count > most:
                best, most, why = made, count, dict(self.why)
            if most >= enough:
                break
        self._restart(why)
        return best

    def _restart(self, why: dict[int, str]) -> None:
        self.why.clear()
        self.why.update(why)

    def _add(self, made: list[Block], model: Any) -> None:
        """Adds the block of a model, without photos that have a place already or fit two."""
        taken = {int(n) + 1 for b in made for n in b.numbers}
        without(model, [n for n in sorted(model.reg_image_ids()) if n in taken])
        if model.num_reg_images() < 2:
            return
        polish(self.colmap, model, self.options, self._stretch())
        if bad := self._misplaced(to_block(model, self.photos, self.keypoints)):
            without(model, [n + 1 for n in bad])
            self.why.update(dict.fromkeys(bad, reasons.REPEATED))
            if model.num_reg_images() < 2:
                return
            polish(self.colmap, model, self.options, self._stretch())
        while weak := self._weak(model):
            self.why.update(weak)
            without(model, [n + 1 for n in weak])
        if model.num_reg_images() >= 2:
            made.append(to_block(model, self.photos, self.keypoints))

    def _weak(self, model: Any) -> dict[int, str]:
        """Numbers of the photos that too few tie points hold, with the reason."""
        block, weak = to_block(model, self.photos, self.keypoints), {}
        for image, count in confirmed(model).items():
            place = int(np.flatnonzero(block.numbers == image - 1)[0])
            if count < _LEAST_POINTS:
                weak[image - 1] = reasons.few_points(count)
            elif count < _STRONG and contradicts(place, block, self.photos):
                weak[image - 1] = reasons.CONTRADICTION
        return weak

    def _stretch(self) -> float:
        """Pixels of the full pictures per pixel in which key points were found."""
        return max(1.0, max(max(p.camera.width, p.camera.height) for p in self.photos) / self.options.side)

    def _misplaced(self, block: Block) -> list[int]:
        """Numbers of the photos that fit two places and whose approximate pose does not decide."""
        found = doubts(block, self.keypoints, self.options)
        return [int(block.numbers[d.photo]) for d in found if not settles(d, block, self.photos)]

    def _two(self, pairs: list[PairMatches]) -> list[Block]:
        """A block of the best pair, where nothing else could be made."""
        for pair in sorted(pairs, key=lambda p: -len(p.rows)):
            if not {pair.first, pair.second} & set(self.why):
                block = block_of_two(pair, self.photos, self.keypoints)
                if block is not None:
                    return [block]
        return []
