"""Photos of a facade are decoded once, and what does not fit into memory is kept in scratch files."""

import numpy as np

from frontage.ortho.decoded import DecodedPhotos


def test_every_photo_is_decoded_once_and_stays_the_same():
    rng = np.random.default_rng(0)
    pictures = {name: rng.integers(0, 256, (40, 50, 3), np.uint8) for name in "abcd"}
    asked = []

    def decode(name):
        asked.append(name)
        return pictures[name]

    photos = DecodedPhotos(decode, most_bytes=2 * 40 * 50 * 3)
    for _ in range(3):
        for name, picture in pictures.items():
            assert (photos(name) == picture).all()
    assert asked == list("abcd")
    assert not isinstance(photos("b"), np.memmap)
    assert isinstance(photos("c"), np.memmap)
