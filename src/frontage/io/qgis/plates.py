"""Print layouts of QGIS: an elevation at a round scale, its title, and a scale bar in metres."""

from collections.abc import Mapping
from uuid import NAMESPACE_URL, uuid5

from lxml import etree
from lxml.builder import E

from frontage.io.drawings.elevation import BORDER_MM, TITLE_MM
from frontage.io.qgis.project import Layer, Look, Plate
from frontage.io.qgis.symbols import symbol

_MAP, _LABEL, _SCALE_BAR, _PAGE = "65639", "65641", "65646", "65638"  # QgsLayoutItemRegistry::ItemType
_WHITE = (255, 255, 255)
_HEAD_MM, _TEXT_PT, _HEAD_PT = 8.0, "8", "12"
_BARS = ((50, 1.0), (100, 2.0), (200, 5.0), (500, 10.0))  # metres of a part of the scale bar, up to a scale


def layout(plate: Plate, layers: Mapping[str, Layer], system: etree._Element) -> etree._Element:
    """Return the element `Layout` of a plate; `system` is the `spatialrefsys` of the facade's plane."""
    w, h = plate.sheet.size
    paper = symbol(Look(_WHITE, 0.0, _WHITE), "Polygon", _WHITE, "")
    page = _item(_PAGE, f"{plate.name} page", (0, 0, w, h), paper)
    made = E.Layout(E.PageCollection(page), name=plate.name, units="mm", printResolution="300")
    made.append(_map(plate, layers, system))
    made.append(_scale_bar(plate))
    x, y, wide = BORDER_MM + 2, h - BORDER_MM - TITLE_MM + 2, w - 2 * BORDER_MM - 4
    head, *about = plate.title
    made.append(_text(plate, "title", head, _HEAD_PT, (x, y, wide, _HEAD_MM)))
    made.append(
        _text(plate, "about", "\n".join(about), _TEXT_PT, (x, y + _HEAD_MM, wide, TITLE_MM - _HEAD_MM))
    )
    return made


def _map(plate: Plate, layers: Mapping[str, Layer], system: etree._Element) -> etree._Element:
    """The map fills the sheet above the title, so that its scale is exactly that of the sheet."""
    (w, h), (x0, y0, x1, y1) = plate.sheet.size, plate.bounds
    wide, high = w - 2 * BORDER_MM, h - 2 * BORDER_MM - TITLE_MM
    half_w, half_h = plate.sheet.metres(wide) / 2, plate.sheet.metres(high) / 2
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    extent = E.Extent(
        xmin=repr(x - half_w), xmax=repr(x + half_w), ymin=repr(y - half_h), ymax=repr(y + half_h)
    )
    shown = (layers[key] for key in plate.layers)
    chosen = E.LayerSet(*(
        E.Layer(layer.key, name=layer.name, source=layer.source, provider=layer.provider) for layer in shown
    ))  # fmt: skip
    item = _item(_MAP, _map_id(plate), (BORDER_MM, BORDER_MM, wide, high), extent, E.crs(system), chosen)
    for key, value in {"keepLayerSet": "true", "mapRotation": "0", "followPreset": "false", "frame": "true",
                       "drawCanvasItems": "true"}.items():  # fmt: skip
        item.set(key, value)
    return item


def _scale_bar(plate: Plate) -> etree._Element:
    part = next((m for scale, m in _BARS if plate.sheet.scale <= scale), plate.sheet.scale / 50)
    length = 1000 * part / plate.sheet.scale
    w, h = plate.sheet.size
    box = (w - BORDER_MM - 4 * length - 14, h - BORDER_MM - 16, 4 * length + 14, 14)
    style = E("text-style", fontFamily="Sans", fontSize=_TEXT_PT, fontSizeUnit="Point", textColor="0,0,0,255",
              textOpacity="1")  # fmt: skip
    item = _item(_SCALE_BAR, f"{plate.name} scale", box, style)
    for key, value in {
        "mapUuid": _uuid(_map_id(plate)), "style": "Single Box", "unitType": "meters", "unitLabel": "m",
        "numMapUnitsPerScaleBarUnit": "1", "numUnitsPerSegment": f"{part:g}", "numSegments": "4",
        "numSegmentsLeft": "0", "segmentSizeMode": "0", "height": "2", "labelBarSpace": "1",
    }.items():  # fmt: skip
        item.set(key, value)
    return item


def _text(
    plate: Plate, name: str, text: str, size: str, box: tuple[float, float, float, float]
) -> etree._Element:
    style = E("text-style", fontFamily="Sans", fontSize=size, fontSizeUnit="Point", textColor="0,0,0,255",
              textOpacity="1")  # fmt: skip
    item = _item(_LABEL, f"{plate.name} {name}", box, style)
    item.set("labelText", text)
    return item


def _item(
    kind: str, name: str, box: tuple[float, float, float, float], *inside: etree._Element
) -> etree._Element:
    """Return an item of a layout: its type, the name that its id follows from, and x, y, width, height mm."""
    x, y, w, h = box
    place, size = f"{x:g},{y:g},mm", f"{w:g},{h:g},mm"
    return E.LayoutItem(
        *inside, type=kind, uuid=_uuid(name), templateUuid=_uuid(name), id=name, position=place,
        positionOnPage=place, size=size, referencePoint="0", visibility="1", opacity="1", background="false",
        frame="false",
    )  # fmt: skip


def _map_id(plate: Plate) -> str:
    return f"{plate.name} map"


def _uuid(name: str) -> str:
    """Return an id that is the same in every run."""
    return "{" + str(uuid5(NAMESPACE_URL, f"frontage:{name}")) + "}"
