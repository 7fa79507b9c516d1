"""Photos are placed by the property of the scan that tells where they are, whichever comes first."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from frontage.orientation import orient
from frontage.orientation.orient import orient_photos
from frontage.orientation.place import COARSE_M, FINE_M
from frontage.orientation.placing import BlockPlace
from frontage.orientation.ties import Blocks
from orientation.paintedwalls import corner_of_two, scan_of
from orientation.test_placing import CAMERAS, POSES, TRUE, block_of

WALLS = corner_of_two()
CHANCE = "placed by chance"
GREY = np.full((600, 800, 3), 90, np.uint8)


def named(photos):
    return tuple(replace(photo, id=f"other {photo.id}") for photo in photos)


@pytest.fixture
def placing(monkeypatch):
    """Orients photos with stand-ins: `tells` has the properties by which a block of so many photos is found.

    If `fine`, pixels of 16 cm find nothing; with them, blocks of `twice` photos fit two places.
    A photo alone is found by every property, as chance has it. What is placed by those in `refused` is not
    believed. Of placed photos the property `chosen` tells most, or the one that placed them.
    """

    def oriented(blocks, photos, *, tells, refused=(), chosen=None, fine=False, twice=()):
        def find_place(block, surface, image_of, start, seed, pixel):
            if len(block.photos) in twice:
                return BlockPlace(TRUE, 100, 1.0 if pixel == COARSE_M else 0.0, 0.1)
            found = surface.kind in tells.get(len(block.photos), ()) and (pixel == FINE_M or not fine)
            return BlockPlace(TRUE, 100) if found else None

        def adjusted(scene, placed, unoriented):
            believed = () if scene.surface.kind in refused else placed.photos
            return SimpleNamespace(photos=believed, kind=scene.surface.kind, left=unoriented, placed=placed)

        def most_telling(photos, surface, scan, *_):
            return replace(surface, kind=chosen or surface.kind)

        monkeypatch.setattr(orient, "find_place", find_place)
        monkeypatch.setattr(orient, "place_alone", lambda photo, *_: replace(photo, id=CHANCE))
        monkeypatch.setattr(orient, "most_telling", most_telling)
        monkeypatch.setattr(orient, "adjusted_orientation", adjusted)
        monkeypatch.setattr(orient, "placed_by_neighbours", lambda scene, placed, left: (placed, left))
        return orient_photos(photos, blocks, SCAN, lambda _: GREY)

    return oriented


def coloured(scan):
    grey = np.clip(scan.intensity * 255, 0, 255).astype(np.uint8)
    return replace(scan, rgb=np.repeat(grey[:, None], 3, axis=1))


SCAN = coloured(scan_of(WALLS, 0.2))
BLOCK, PHOTOS, _ = block_of(WALLS, POSES, CAMERAS)


def test_a_block_is_looked_for_with_every_property_before_photos_are_tried_on_their_own(placing):
    found = placing(Blocks((BLOCK,), ()), PHOTOS, tells={3: ("colour",)})
    assert found.kind == "colour" and not found.left
    assert found.placed.photos[0].pose.t == pytest.approx(PHOTOS[0].pose.t)


def test_the_next_property_is_tried_where_nothing_that_was_placed_is_believed(placing):
    found = placing(Blocks((BLOCK,), ()), PHOTOS, tells={3: ("intensity", "colour")}, refused=("intensity",))
    assert found.kind == "colour" and found.photos


def test_photos_alone_are_the_last_resort(placing):
    found = placing(Blocks((BLOCK,), ()), PHOTOS, tells={}, refused=("intensity",))
    assert found.kind == "colour" and len(found.photos) == 3


def test_nothing_is_told_by_the_last_property(placing):
    kinds = ("intensity", "colour", "geometry")
    found = placing(Blocks((BLOCK,), ()), PHOTOS, tells={3: kinds}, refused=kinds)
    assert found.kind == "geometry" and not len(found.photos)


def test_a_block_without_a_place_is_looked_for_with_the_property_that_tells_most(placing):
    other = replace(BLOCK, numbers=np.array([3, 4]), photos=named(BLOCK.photos[:2]))
    photos = [*PHOTOS, *named(PHOTOS[:2])]
    tells = {3: ("intensity",), 2: ("colour",)}
    found = placing(Blocks((BLOCK, other), ()), photos, tells=tells, chosen="colour")
    assert sorted(found.placed.numbers.tolist()) == [0, 1, 2, 3, 4] and not found.left
    assert CHANCE not in {photo.id for photo in found.placed.photos}


def test_blocks_are_looked_for_more_finely_where_nothing_has_a_place(placing):
    tells = {3: ("colour",)}
    found = placing(Blocks((BLOCK,), ()), PHOTOS, tells=tells, fine=True)
    assert found.kind == "colour" and not found.left
    assert CHANCE not in {photo.id for photo in found.placed.photos}


def test_a_block_that_fits_two_places_is_not_looked_for_more_finely(placing):
    found = placing(Blocks((BLOCK,), ()), PHOTOS, tells={}, twice=(3,))
    assert not len(found.photos) and {one.code for one in found.left} == {"O103"}
    assert len(found.left) == 3
