"""The pictures of a building's facades on few pages, as graphics cards like them.

The sides of a page are powers of two. Around every picture its outermost pixels are repeated, so that reduced
copies (mipmaps) of the page mix no neighbour into it, and surfaces may reach a little beyond it. Pictures
stand on the blocks of the JPEG.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float

MAX_TEXTURE = 4096
"""Pixels of a side that every graphics card and viewer can handle."""
BEYOND = 0.02
"""Of a picture's side: how far texture coordinates may reach beyond the picture."""
_BLOCK_PX = 16  # of the JPEG; so wide a border leaves a pixel of itself after four times halving
_JPEG_QUALITY = 90


_Page = list[tuple[int, int, int]]
"""The pictures on a page: the number of each, its column and its row."""


@dataclass(frozen=True)
class Place:
    """Where a picture stands: the number of its page, its upper left corner and its size (u, v) there."""

    page: int
    corner: tuple[float, float]
    size: tuple[float, float]

    def on_page(self, uv: Float) -> Float:
        """Converts texture coordinates (..., 2) of the picture, 0..1, to those of the page."""
        return np.asarray(np.array(self.corner) + np.asarray(uv) * np.array(self.size))


@dataclass(frozen=True, eq=False)
class Atlas:
    """Pages as JPEG, and where the pictures stand on them, in the given order."""

    pages: tuple[bytes, ...]
    places: tuple[Place, ...]


def make_atlas(pictures: Sequence[bytes], largest: int = MAX_TEXTURE) -> Atlas:
    """Puts JPEG pictures on pages with sides of at most `largest` px, a power of two of at least 64.

    A picture that is larger than a page is reduced by averaging.
    """
    most = int((largest - 4 * _BLOCK_PX) / (1 + 2 * BEYOND))
    images = [reduced(decoded(jpeg), most) for jpeg in pictures]
    pages, places = list[bytes](), dict[int, Place]()
    for number, page in enumerate(_pages([_with_border(image) for image in images], largest)):
        canvas = _canvas([(images[k], x, y) for k, x, y in page])
        height, width = canvas.shape[:2]
        for k, x, y in page:
            h, w = images[k].shape[:2]
            corner = ((x + _border(w)) / width, (y + _border(h)) / height)
            places[k] = Place(number, corner, (w / width, h / height))
        pages.append(encoded(canvas))
    return Atlas(tuple(pages), tuple(places[k] for k in range(len(images))))


def decoded(jpeg: bytes) -> Array:
    """Returns the pixels (h, w, 3) uint8 of a JPEG: blue, green, red, as OpenCV has them."""
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR))


def encoded(image: Array) -> bytes:
    """Returns the JPEG of pixels (h, w, 3) uint8: blue, green, red."""
    return bytes(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1])


def reduced(image: Array, limit: int) -> Array:
    """Returns a picture (h, w, 3), reduced by averaging where a side is longer than `limit` px."""
    scale = limit / max(image.shape[:2])
    if scale >= 1:
        return image
    size = [max(1, round(side * scale)) for side in image.shape[1::-1]]
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))


def _border(side: int) -> int:
    """The px by which a side of a picture is continued at its beginning, in whole blocks."""
    return _BLOCK_PX * int(np.ceil(BEYOND * side / _BLOCK_PX + 1))


def _with_border(image: Array) -> tuple[int, int]:
    """Width and height of a picture with its border, in whole blocks."""
    h, w = (-(-(side + 2 * _border(side)) // _BLOCK_PX) * _BLOCK_PX for side in image.shape[:2])
    return w, h


def _pages(sizes: Sequence[tuple[int, int]], largest: int) -> list[_Page]:
    """Which pictures (width, height) stand on every page.

    Of all widths of pages, the one is chosen with which all pages together have the fewest pixels.
    """
    widest = max((w for w, _ in sizes), default=1)
    widths = [_power_of_two(widest)]
    while 2 * widths[-1] <= largest:
        widths.append(2 * widths[-1])
    return min((_rows(sizes, width, largest) for width in widths), key=lambda pages: _area(pages, sizes))


def _rows(sizes: Sequence[tuple[int, int]], width: int, height: int) -> list[_Page]:
    """Puts pictures on pages of at most `width` x `height` px in rows, the highest first."""
    pages: list[_Page] = []
    x = top = high = 0
    for k in sorted(range(len(sizes)), key=lambda k: (-sizes[k][1], -sizes[k][0], k)):
        w, h = sizes[k]
        if not pages or x + w > width:
            x, top, high = 0, top + high, h
            if not pages or top + h > height:
                pages.append([])
                top = 0
        pages[-1].append((k, x, top))
        x += w
    return pages


def _area(pages: Sequence[_Page], sizes: Sequence[tuple[int, int]]) -> int:
    """The pixels of all pages together."""
    return sum(int(np.prod(_page_size([(sizes[k], x, y) for k, x, y in page]))) for page in pages)


def _page_size(placed: Sequence[tuple[tuple[int, int], int, int]]) -> tuple[int, int]:
    """Width and height of a page that holds pictures of sizes (width, height) at columns and rows."""
    width = max(x + w for (w, _), x, _ in placed)
    height = max(y + h for (_, h), _, y in placed)
    return _power_of_two(width), _power_of_two(height)


def _canvas(placed: Sequence[tuple[Array, int, int]]) -> Array:
    """Draws pictures with their borders at columns and rows; the rest of the page has their mean colour."""
    sizes = [_with_border(image) for image, _, _ in placed]
    width, height = _page_size([(size, x, y) for (_, x, y), size in zip(placed, sizes, strict=True)])
    canvas = np.empty((height, width, 3), np.uint8)
    canvas[:] = np.mean([image.mean((0, 1)) for image, _, _ in placed], axis=0)
    for (image, x, y), (w, h) in zip(placed, sizes, strict=True):
        above, left = _border(image.shape[0]), _border(image.shape[1])
        around = (above, h - image.shape[0] - above, left, w - image.shape[1] - left)
        canvas[y : y + h, x : x + w] = cv2.copyMakeBorder(image, *around, cv2.BORDER_REPLICATE)
    return canvas


def _power_of_two(size: int) -> int:
    return 1 << (size - 1).bit_length()
