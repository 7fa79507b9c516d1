"""Pictures on pages: sides are powers of two, borders survive mipmaps, and every picture is found again."""

import cv2
import numpy as np
import pytest

from frontage.exports.atlas import BEYOND, Atlas, decoded, encoded, make_atlas

COLOURS = ((200, 40, 40), (40, 200, 40), (40, 40, 200), (200, 200, 40), (40, 200, 200))
SIZES = ((300, 120), (90, 400), (640, 333), (50, 50), (700, 256))


def plain(size: tuple[int, int], colour: tuple[int, int, int]) -> bytes:
    return encoded(np.full((size[1], size[0], 3), colour, np.uint8))


def made(largest: int) -> Atlas:
    return make_atlas([plain(*one) for one in zip(SIZES, COLOURS, strict=True)], largest)


def colour_at(atlas: Atlas, number: int, uv: tuple[float, float], halved: int) -> np.ndarray:
    """What a graphics card shows at (u, v) of a picture, on a page that was halved several times."""
    place = atlas.places[number]
    page = decoded(atlas.pages[place.page])
    for _ in range(halved):
        page = cv2.resize(page, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    u, v = place.on_page(np.array(uv))
    return page[
        min(int(v * page.shape[0]), page.shape[0] - 1), min(int(u * page.shape[1]), page.shape[1] - 1)
    ]


@pytest.mark.parametrize("largest", [512, 4096])
def test_pages_are_powers_of_two_and_no_larger_than_asked(largest: int) -> None:
    atlas = made(largest)
    assert len(atlas.places) == len(SIZES)
    for page in atlas.pages:
        for side in decoded(page).shape[:2]:
            assert side <= largest and side & (side - 1) == 0
    assert (len(atlas.pages) == 1) == (largest == 4096)


def test_pictures_keep_their_colour_up_to_their_border_in_reduced_copies() -> None:
    atlas = made(2048)
    for number, colour in enumerate(COLOURS):
        for uv in ((0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (-BEYOND, 0.5), (1 + BEYOND, 1 + BEYOND)):
            for halved in (0, 2, 4):
                assert np.abs(colour_at(atlas, number, uv, halved).astype(int) - colour).max() < 12


def test_a_picture_that_is_too_large_is_reduced_and_keeps_its_place() -> None:
    picture = np.zeros((700, 3000, 3), np.uint8)
    picture[:, 1500:] = 250
    atlas = make_atlas([encoded(picture)], 1024)
    assert decoded(atlas.pages[0]).shape[1] == 1024
    left, right = (colour_at(atlas, 0, (u, 0.5), 0).mean() for u in (0.495, 0.505))
    assert left < 20 and right > 230


def test_without_pictures_there_is_no_page() -> None:
    assert make_atlas([]).pages == () and make_atlas([]).places == ()


def test_pages_waste_no_power_of_two() -> None:
    """Two wide pictures stand one above the other: side by side, the page would be twice as large."""
    atlas = make_atlas([plain((900, 300), COLOURS[0]), plain((500, 300), COLOURS[1])])
    assert decoded(atlas.pages[0]).shape[:2] == (1024, 1024)
