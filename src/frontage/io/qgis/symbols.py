"""How QGIS is told to draw: symbols, colours by value, labels, pictures and depths."""

from collections.abc import Mapping

from lxml import etree
from lxml.builder import E

from frontage.io.qgis.project import Colour, Layer, Look, Shape

_SYMBOLS = {"Point": ("marker", "SimpleMarker"), "Line": ("line", "SimpleLine"),
            "Polygon": ("fill", "SimpleFill")}  # fmt: skip
_DEPTHS = ((-0.5, (178, 24, 43)), (0.0, (247, 247, 247)), (0.5, (33, 102, 172)))
"""Metres behind the wall with their colours: what stands out is red, what is recessed blue."""


def renderer(look: Look, shape: Shape) -> etree._Element:
    """Return the element `renderer-v2` of a vector layer."""
    values = look.colours if look.by else ()
    symbols = [symbol(look, shape, colour, str(k)) for k, (_, colour) in enumerate(values)]
    symbols.append(symbol(look, shape, look.stroke, str(len(values))))
    if not look.by:
        return E("renderer-v2", E.symbols(*symbols), type="singleSymbol")
    categories = [
        E.category(symbol=str(k), value=value, label=value or "other", render="true")
        for k, value in enumerate((*(v for v, _ in values), ""))
    ]
    return E("renderer-v2", E.categories(*categories), E.symbols(*symbols), type="categorizedSymbol",
             attr=look.by)  # fmt: skip


def symbol(look: Look, shape: Shape, colour: Colour, name: str) -> etree._Element:
    """Return a symbol of one simple layer, for a shape other than a raster."""
    kind, layer = _SYMBOLS[shape]
    width, stroke = f"{look.width:g}", _colour(colour)
    fill = (
        {"color": "0,0,0,0", "style": "no"}
        if look.fill is None
        else {"color": _colour(look.fill), "style": "solid"}
    )
    facts = {
        "Point": {"name": "arrow" if look.turned else "circle", "color": stroke, "size": width,
                  "size_unit": "MM", "outline_style": "no"},
        "Line": {"line_color": stroke, "line_width": width, "line_width_unit": "MM", "capstyle": "flat"},
        "Polygon": {**fill, "outline_color": stroke, "outline_width": width, "outline_width_unit": "MM",
                    "outline_style": "solid", "joinstyle": "miter"},
    }[shape]  # fmt: skip
    parts = [_map(facts)]
    if (driven := _driven(look)) is not None:
        parts.append(driven)
    drawn = E.layer(*parts, enabled="1", locked="0")
    drawn.set("pass", "0")
    drawn.set("class", layer)
    return E.symbol(drawn, name=name, type=kind, alpha="1", clip_to_extent="1", force_rhr="0")


def _driven(look: Look) -> etree._Element | None:
    """Return what of a symbol the values of a feature decide; None if nothing."""
    wanted = {"angle": f'"{look.turned}"' if look.turned else ""}
    wanted["outlineStyle"] = f"if({look.dashed}, 'dash', 'solid')" if look.dashed else ""
    options = [
        E.Option(E.Option(name="active", type="bool", value="true"), _text("expression", expression),
                 E.Option(name="type", type="int", value="3"), name=name, type="Map")
        for name, expression in wanted.items() if expression
    ]  # fmt: skip
    if not options:
        return None
    properties = E.Option(*options, name="properties", type="Map")
    everything = E.Option(_text("name", ""), properties, _text("type", "collection"), type="Map")
    return E("data_defined_properties", everything)


def labels(look: Look) -> etree._Element:
    """Return the element `labeling`: small texts with a light border."""
    style = E("text-style", E("text-buffer", bufferDraw="1", bufferSize="0.6", bufferSizeUnits="MM",
                              bufferColor="255,255,255,220"),
              fieldName=look.label, isExpression="1", fontFamily="Sans", fontSize="2.2", fontSizeUnit="MM",
              textColor="40,40,40,255", textOpacity="1")  # fmt: skip
    settings = E.settings(style, E.placement(placement="1", quadOffset="4"),
                          E.rendering(displayAll="0", drawLabels="1", obstacle="0"))  # fmt: skip
    return E.labeling(settings, type="simple")


def raster_pipe(layer: Layer) -> etree._Element:
    """Return the element `pipe` of a raster: its colours as they are, or depths in colours."""
    drawn = _depths() if layer.depths else E.rasterrenderer(
        type="multibandcolor", redBand="1", greenBand="2", blueBand="3", alphaBand="4", opacity="1"
    )  # fmt: skip
    smooth = E.rasterresampler(zoomedOutResampler="bilinear", maxOversampling="4")
    return E.pipe(drawn, smooth)


def _depths() -> etree._Element:
    (low, _), *_, (high, _) = _DEPTHS
    items = [
        E.item(value=f"{m:g}", label=f"{m:g} m", color="#{:02x}{:02x}{:02x}".format(*c), alpha="255")
        for m, c in _DEPTHS
    ]
    ramp = E.colorrampshader(*items, colorRampType="INTERPOLATED", classificationMode="1", clip="0",
                             minimumValue=f"{low:g}", maximumValue=f"{high:g}")  # fmt: skip
    return E.rasterrenderer(
        E.rastershader(ramp), type="singlebandpseudocolor", band="1", opacity="1", alphaBand="-1",
        classificationMin=f"{low:g}", classificationMax=f"{high:g}",
    )  # fmt: skip


def _map(facts: Mapping[str, str]) -> etree._Element:
    return E.Option(*(_text(k, v) for k, v in facts.items()), type="Map")


def _text(name: str, value: str) -> etree._Element:
    return E.Option(name=name, type="QString", value=value)


def _colour(colour: Colour) -> str:
    return "{},{},{},255".format(*colour)
