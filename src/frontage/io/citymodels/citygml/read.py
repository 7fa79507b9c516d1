"""Reading CityGML as a stream: one building in memory at a time.

Entities are not resolved, and neither DTDs nor the network are used. A building that refers to elements
outside it (shared polygons) is put aside; the elements that it needs are collected in further passes.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from frontage.io.citymodels.citygml.geometry import HREF, bounded, identifier, local
from frontage.io.citymodels.citygml.objects import building_of
from frontage.io.citymodels.citygml.texture import TextureCollector
from frontage.io.citymodels.deferred import DeferredPlacement
from frontage.io.citymodels.draft import BuildingDraft

_MEMBERS = ("cityObjectMember", "featureMember", "featureMembers", "member", "appearanceMember")
_EMPTIED = [f"{{*}}{name}" for name in ("Building", *_MEMBERS)]
_SAFE: dict[str, Any] = {"resolve_entities": False, "no_network": True, "load_dtd": False, "huge_tree": False}
_FLAT = etree.XPath("boolean(ancestor-or-self::*[@srsDimension='2'] | .//@srsDimension[.='2'])")
_ANCHORS = ("anchorPoint", "anchorDefinition")  # of a local system, CityGML 2 and 3
_PASSES = 8  # at most: references from referenced elements to further ones


def read_citygml(path: Path, place: DeferredPlacement) -> Iterator[BuildingDraft]:
    """Yield the buildings that touch the bounds; those that refer to elements outside them come last.

    Raises lxml's XMLSyntaxError on damaged XML, and ValueError when the file is not a city model.
    """
    yield from _Reader(path, place).drafts()


class _Reader:
    """One file: the buildings put aside, and whether textures are stated outside the buildings."""

    def __init__(self, path: Path, place: DeferredPlacement) -> None:
        self._path = path
        self._place = place
        self._waiting: list[tuple[int, bytes]] = []
        self._missing: set[str] = set()
        self._appearances = False

    def drafts(self) -> list[BuildingDraft]:
        """All buildings that touch the bounds."""
        found: list[BuildingDraft] = []
        for number, element in enumerate(self._buildings(), 1):
            if self._place.bounded and _is_far(element, self._place):
                continue
            own = _by_id(element)
            if outside := _references(element) - set(own):
                self._missing |= outside
                self._waiting.append((number, etree.tostring(element)))
            else:
                found += self._draft(element, number, own)
        shared = _shared(self._path, self._missing)
        for number, text in self._waiting:
            element = etree.fromstring(text, etree.XMLParser(**_SAFE))
            found += self._draft(element, number, shared | _by_id(element))
        if self._appearances:
            textures = TextureCollector(found)
            with open(self._path, "rb") as file:
                for _, element in etree.iterparse(file, tag=["{*}ParameterizedTexture", *_EMPTIED], **_SAFE):
                    textures.collect(element)
                    _free(element)
            textures.assign()
        return found

    def _draft(
        self, element: etree._Element, number: int, by_id: dict[str, etree._Element]
    ) -> list[BuildingDraft]:
        """The building with the textures stated inside it; nothing when it does not touch the bounds."""
        draft = building_of(element, number, bounded(by_id))
        if not self._place.touches(draft.points()):
            return []
        textures = TextureCollector([draft])
        textures.collect(element)
        textures.assign()
        return [draft]

    def _buildings(self) -> Iterator[etree._Element]:
        """Yield every Building element and empty it afterwards; the members around them are emptied too."""
        tags = [f"{{*}}{name}" for name in ("CityModel", "Envelope", *_ANCHORS)] + _EMPTIED
        with open(self._path, "rb") as file:
            context = etree.iterparse(file, events=("start", "end"), tag=tags, **_SAFE)
            for event, element in context:
                name = local(element)
                if event == "start":
                    self._start(name, element)
                elif name in _ANCHORS:
                    self._place.state_anchor(element.get("codeSpace"), element.text or "")
                elif name == "Building":
                    named = (e.get("srsName") for e in element.iter() if isinstance(e.tag, str))
                    self._place.state_crs(next((srs for srs in named if srs), None))
                    yield element
                    _free(element)
                elif name in _MEMBERS:
                    _free(element)
        root = context.root
        if root is None or local(root) != "CityModel":
            raise ValueError(f"its root is {'nothing' if root is None else local(root)}, not CityModel")
        _acceptable(root)

    def _start(self, name: str, element: etree._Element) -> None:
        """Take what an element states before its content is read."""
        if name == "CityModel":
            _acceptable(element)
        elif name == "Envelope":
            self._place.state_crs(element.get("srsName"))
        self._appearances |= name == "appearanceMember"


def _is_far(element: etree._Element, place: DeferredPlacement) -> bool:
    """Whether all coordinates of a building lie outside the bounds; False where that is not obvious.

    This quick test spares the reading of most of a large file.
    """
    if next(element.iter("{*}coordinates", "{*}ImplicitGeometry"), None) is not None or _FLAT(element):
        return False
    texts = [e.text or "" for e in element.iter("{*}posList", "{*}pos")]
    try:
        points = np.array(" ".join(texts).split(), np.float64)
    except ValueError:
        return False
    if not len(points) or len(points) % 3:
        return False
    return not place.touches(points.reshape(-1, 3))


def _acceptable(element: etree._Element) -> None:
    if element.getroottree().docinfo.doctype:
        raise ValueError("it has a document type declaration, which is not accepted")


def _free(element: etree._Element) -> None:
    """Free the memory of an element and of those before it."""
    element.clear(keep_tail=True)
    parent = element.getparent()
    while parent is not None and element.getprevious() is not None:
        del parent[0]


def _by_id(element: etree._Element) -> dict[str, etree._Element]:
    return {name: e for e in element.iter() if isinstance(e.tag, str) and (name := identifier(e))}


def _references(element: etree._Element) -> set[str]:
    """The identifiers that hrefs within the file refer to."""
    named = (e.get(HREF, "") for e in element.iter() if isinstance(e.tag, str))
    return {href[1:] for href in named if href.startswith("#")}


def _shared(path: Path, missing: set[str]) -> dict[str, etree._Element]:
    """The elements with the given identifiers, and those that they refer to in turn."""
    found: dict[str, etree._Element] = {}
    for _ in range(_PASSES):
        if not missing:
            break
        copies: dict[str, etree._Element] = {}
        with open(path, "rb") as file:
            for _, element in etree.iterparse(file, events=("end",), **_SAFE):
                if (name := identifier(element)) in missing:
                    text = etree.tostring(element, with_tail=False)
                    copies[name] = etree.fromstring(text, etree.XMLParser(**_SAFE))
                if local(element) in _MEMBERS:
                    _free(element)
        for element in copies.values():
            found |= _by_id(element)
        missing = {r for e in copies.values() for r in _references(e)} - set(found)
    return found
