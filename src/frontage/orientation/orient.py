"""The entry function of the room: photos oriented against each other and against the scan.

The order is that of paper B, section 2.2: blocks of photos from tie points (2.2.1, `ties`), control points
from the reflectance of the scanner (2.2.2), one adjustment of everything. Photos of one exposure of a rig are
brought onto one body as soon as one of them has a place.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Photo, Rig, Scan
from frontage.orientation.alone import beside, place_alone
from frontage.orientation.carry import carried_by_rigs
from frontage.orientation.drawnwall import Similarity
from frontage.orientation.final import adjusted_orientation
from frontage.orientation.neighbours import placed_by_neighbours
from frontage.orientation.network import TiePoints
from frontage.orientation.nouns import Block
from frontage.orientation.options import OrientationOptions
from frontage.orientation.place import COARSE_M, FINE_M, Start
from frontage.orientation.placed import PRIOR_SIGMAS, Placed, Scene, Tell, merged
from frontage.orientation.placing import BlockPlace, find_place, placed_photos
from frontage.orientation.reflectance.surface import scanned_surface, sources_of
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.result import Orientation, Unoriented
from frontage.orientation.sources import most_telling
from frontage.orientation.start import levelled, start_from_poses
from frontage.orientation.ties import Blocks
from frontage.orientation.ties.reasons import is_copy
from frontage.orientation.upright import plumb_line, turn_upright, up_from_cameras

_AMBIGUOUS = "O103"


def orient_photos(
    photos: Sequence[Photo],
    blocks: Blocks,
    scan: Scan,
    image_of: ImageOf,
    *,
    options: OrientationOptions | None = None,
    camera_sigmas: Sequence[Float] = (),
    rigs: Sequence[Rig] = (),
    seed: int = 0,
    tell: Tell | None = None,
) -> Orientation:
    """Orients photos in the frame of a scan.

    photos         with approximate poses (and their covariances), or with none
    blocks         of these photos, from tie points
    image_of       returns the picture (h, w, 3) uint8 of a photo id
    camera_sigmas  per photo, standard errors of its camera's parameters; empty: all are exact
    rigs           tell which photos were taken at the same time by cameras that are fixed to one another
    tell           is told what is being done, once per block and photo

    Photos that cannot be oriented are listed with the reason. Raises ValueError when `options.source` names
    something that the scan does not have.
    """
    options = options or OrientationOptions()
    kinds = sources_of(scan) if options.source == "auto" else (options.source,)

    def scene_of(kind: str) -> Scene:
        surface = scanned_surface(scan, kind, seed)
        return Scene(photos, surface, image_of, camera_sigmas, seed, tell or _silent, rigs, blocks.common)

    for scene, placed, unoriented in _attempts(blocks, scan, scene_of, kinds):
        found = adjusted_orientation(scene, merged(placed), unoriented)
        if found.photos:
            break
    return found


Attempt = tuple[Scene, list[Placed], list[Unoriented]]


def _attempts(
    blocks: Blocks, scan: Scan, scene_of: Callable[[str], Scene], kinds: Sequence[str]
) -> Iterator[Attempt]:
    """Places photos by one property of the scan after the other; by the last one whatever it tells.

    A photo on its own finds a place by chance where a property tells nothing, much sooner than a block does.
    Blocks are therefore looked for with every property before photos are tried on their own: first by what is
    larger than 16 cm, such as windows, then by what is larger than 8 cm, such as bricks.
    """
    refused = {kind: list[Unoriented]() for kind in kinds}
    for pixel in (COARSE_M, FINE_M):
        for kind in list(refused):
            scene = scene_of(kind)
            placed, unoriented = _searched(blocks, scene, pixel, refused.pop(kind))
            if not placed:
                refused[kind] = unoriented
                continue
            if len(kinds) > 1:
                scene, placed, unoriented = _with_most_telling(blocks, scan, scene, placed, unoriented, pixel)
            yield scene, *_place_others(scene, placed, unoriented)
    for k, (kind, unoriented) in enumerate(refused.items()):
        scene = scene_of(kind)
        placed, unoriented = _place_others(scene, [], unoriented)
        if placed or k + 1 == len(refused):
            yield scene, placed, unoriented


def _searched(
    blocks: Blocks, scene: Scene, pixel: float, refused: list[Unoriented]
) -> tuple[list[Placed], list[Unoriented]]:
    """Places blocks, without those that a coarser search `refused` because they fit several places."""
    doubtful = [one for one in refused if one.code == _AMBIGUOUS]
    named = {one.photo for one in doubtful}
    waiting = [block for block in blocks.blocks if named.isdisjoint(photo.id for photo in block.photos)]
    placed, unoriented = _place_blocks(waiting, scene, pixel)
    return placed, [Unoriented(n, "O101", reason) for n, reason in blocks.unoriented] + doubtful + unoriented


def _with_most_telling(
    blocks: Blocks,
    scan: Scan,
    scene: Scene,
    placed: list[Placed],
    unoriented: list[Unoriented],
    pixel: float,
) -> Attempt:
    """The scene with what tells most of the placed photos; blocks without a place are tried with it."""
    known = [photo for part in placed for photo in part.photos]
    surface = most_telling(known, scene.surface, scan, scene.image_of, scene.seed)
    if surface.kind == scene.surface.kind:
        return scene, placed, unoriented
    scene = replace(scene, surface=surface)
    there = {int(number) for part in placed for number in part.numbers}
    waiting = [block for block in blocks.blocks if there.isdisjoint(block.numbers.tolist())]
    more, refused = _place_blocks(waiting, scene, pixel)
    tried = {photo.id for block in waiting for photo in block.photos}
    return scene, placed + more, [one for one in unoriented if one.photo not in tried] + refused


def _place_others(
    scene: Scene, placed: list[Placed], unoriented: list[Unoriented]
) -> tuple[list[Placed], list[Unoriented]]:
    """Places photos by their rigs, by what they share with placed ones, and on their own."""
    for find in (placed_by_neighbours, _rescued, placed_by_neighbours):
        placed, unoriented = find(scene, *carried_by_rigs(scene, placed, unoriented))
    return carried_by_rigs(scene, placed, unoriented)


def _place_blocks(
    blocks: Sequence[Block], scene: Scene, pixel: float
) -> tuple[list[Placed], list[Unoriented]]:
    placed, unoriented = list[Placed](), list[Unoriented]()
    for block in blocks:
        scene.tell("placing")
        found = _place_block(block, scene, pixel)
        if isinstance(found, Placed):
            placed.append(found)
        else:
            unoriented += found
    return placed, unoriented


def _place_block(block: Block, scene: Scene, pixel: float) -> Placed | list[Unoriented]:
    """The photos of a block in the scan, or the reason why they are not."""
    start = start_from_poses(block, scene.given)
    if start is None:
        start = _start_without_poses(block, scene.image_of)
    else:
        start = levelled(block, start, scene.image_of)
    place = find_place(block, scene.surface, scene.image_of, start, scene.seed, pixel)
    if place is None:
        return _refused(block, "O102", "nothing of the scan could be found in the photos matched with it")
    if place.ambiguous and not _decided_by_poses(place, start):
        text = f"it fits {place.rival_off:.1f} m away as well as in the best place"
        return _refused(block, _AMBIGUOUS, text)
    xyz = place.similarity.apply(block.points)
    ties = TiePoints(xyz, block.photo, block.point, block.pixels, block.sizes)
    return Placed(block.numbers, tuple(placed_photos(block, place.similarity)), ties)


def _start_without_poses(block: Block, image_of: ImageOf) -> Start:
    """A start that only knows which way is up."""
    up = plumb_line(block.photos, image_of, up_from_cameras(block.photos))
    return Start(Similarity(1.0, turn_upright(up), np.zeros(3)))


def _decided_by_poses(place: BlockPlace, start: Start) -> bool:
    """Whether approximate poses rule the other place out."""
    return place.rival_off > PRIOR_SIGMAS * start.sigma_shift


def _refused(block: Block, code: str, reason: str) -> list[Unoriented]:
    return [Unoriented(photo.id, code, reason) for photo in block.photos]


def _rescued(
    scene: Scene, placed: list[Placed], unoriented: list[Unoriented]
) -> tuple[list[Placed], list[Unoriented]]:
    """Tries photos without a place on their own; those without a pose beside the ones taken around them."""
    number_of = {photo.id: k for k, photo in enumerate(scene.given)}
    known = {int(n): photo for part in placed for n, photo in zip(part.numbers, part.photos, strict=True)}
    left: list[Unoriented] = []
    for one in unoriented:
        number, found = number_of[one.photo], None
        # On its own, a photo fits at both places, too; a copy tells nothing that its twin does not.
        if one.code != _AMBIGUOUS and not is_copy(one.reason):
            scene.tell("placing")
            photo = beside(number, scene.given[number], known)
            found = place_alone(photo, scene.surface, scene.image_of, scene.seed)
        if found is None:
            left.append(one)
        else:
            placed.append(Placed(np.array([number]), (found,), TiePoints.none()))
    return placed, left


def _silent(_: str) -> None:
    """Tells nobody."""
