"""Textures of CityGML 1 to 3: which part of which picture lies on which ring. Pictures are not read."""

from collections.abc import Iterable, Iterator

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float
from frontage.io.citymodels.citygml.geometry import local
from frontage.io.citymodels.draft import BuildingDraft
from frontage.model.citymodel import Texture


class TextureCollector:
    """Collects the texture coordinates of the rings of some drafts, and assigns them to the polygons."""

    def __init__(self, drafts: Iterable[BuildingDraft]) -> None:
        self._faces = [f for d in drafts for s in d.shells for f in s.faces if f.rings and f.texture is None]
        self._wanted = {name for f in self._faces for name in f.names}
        self._found: dict[str, tuple[str, Float]] = {}

    def collect(self, element: etree._Element) -> None:
        """Collect the coordinates in the ParameterizedTextures at or below an element."""
        for texture in element.iter("{*}ParameterizedTexture"):
            image = next(((e.text or "").strip() for e in texture.iter("{*}imageURI")), "")
            for ring, places in _coordinates(texture):
                if image and ring in self._wanted:
                    self._found.setdefault(ring, (image, places))

    def assign(self) -> None:
        """Give a texture to every polygon whose rings all have coordinates."""
        for face in self._faces:
            stated = [self._found.get(name) for name in face.names]
            known = [s for s in stated if s is not None]
            if len(known) == len(face.rings) == len(stated):
                face.texture = Texture(known[0][0], tuple(places for _, places in known))


def _coordinates(texture: etree._Element) -> Iterator[tuple[str, Float]]:
    """Yield the id of every ring and its texture coordinates (k, 2); broken lists of numbers are skipped.

    Version 3.0 lists all coordinates first, then their rings in the same order.
    """
    for listed in texture.iter("{*}TexCoordList"):
        stated = [e for e in listed if local(e) == "textureCoordinates"]
        rings = [e.text or "" for e in listed if local(e) == "ring"]
        names = [e.get("ring") or (rings[k] if k < len(rings) else "") for k, e in enumerate(stated)]
        for e, name in zip(stated, names, strict=True):
            try:
                values = np.array((e.text or "").split(), np.float64)
            except ValueError:
                continue
            if len(values) and len(values) % 2 == 0:
                yield name.strip().removeprefix("#"), values.reshape(-1, 2)
