"""Decoded photos are kept, within bounds."""

import numpy as np

from frontage.io.photos.cache import PixelCache


def test_pictures_are_decoded_once_while_there_is_room() -> None:
    cache, asked = PixelCache(most_bytes=250), list[str]()

    def picture(name: str) -> np.ndarray:
        def decode() -> np.ndarray:
            asked.append(name)
            return np.full(100, ord(name), np.uint8)

        return cache.get(name, decode)

    assert [picture(name)[0] for name in "aabab"] == [97, 97, 98, 97, 98]
    assert asked == ["a", "b"]
    picture("c")  # the oldest, a, makes room
    picture("b")
    picture("a")
    assert asked == ["a", "b", "c", "a"]


def test_a_picture_larger_than_the_cache_is_not_kept() -> None:
    cache = PixelCache(most_bytes=10)
    assert cache.get("k", lambda: np.zeros(100, np.uint8)).size == 100
    assert cache.get("k", lambda: np.ones(100, np.uint8))[0] == 1
