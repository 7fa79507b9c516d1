"""The pictures on the polygons of a CityJSON file, and where their corners lie in them."""

from collections.abc import Sequence
from typing import Any

from frontage.geometry.arrays import Float
from frontage.model.citymodel import Texture

THEME = "facades"
_DIGITS = 6  # of a position in a picture: a hundredth of a pixel of the largest one
_FORMATS = {"jpg": "JPG", "jpeg": "JPG", "png": "PNG"}
_NONE = [None]


class Appearance:
    """Pictures and positions in them, each once, numbered in the order of their first use."""

    def __init__(self) -> None:
        self._pictures: dict[str, int] = {}
        self._places: dict[tuple[float, ...], int] = {}

    def polygon(self, texture: Texture | None, kept: Sequence[Sequence[int]]) -> list[list[int | None]]:
        """Return what the file says of a polygon; `kept` are the corners of every ring that it holds."""
        if texture is None or len(texture.rings) != len(kept):
            return [list(_NONE) for _ in kept]
        picture = self._pictures.setdefault(texture.image, len(self._pictures))
        return [
            [picture, *(self._place(ring, k) for k in own)]
            for ring, own in zip(texture.rings, kept, strict=True)
        ]

    def _place(self, ring: Float, k: int) -> int:
        u, v = (round(float(value), _DIGITS) for value in ring[k])
        return self._places.setdefault((u, v), len(self._places))

    def to_json(self) -> dict[str, Any]:
        """Return the object `appearance`. Beyond its picture a wall has the colours of the border."""
        pictures = [
            {"type": _FORMATS[name.rpartition(".")[2].lower()], "image": name, "wrapMode": "clamp",
             "textureType": "specific"}
            for name in self._pictures
        ]  # fmt: skip
        return {
            "textures": pictures,
            "vertices-texture": [list(place) for place in self._places],
            "default-theme-texture": THEME,
        }

    def __bool__(self) -> bool:
        """Whether there is any picture."""
        return bool(self._pictures)
