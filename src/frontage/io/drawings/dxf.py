"""Writes elevations as DXF (AutoCAD 2010): model space in metres, one layout to scale per facade."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from frontage.errors import MissingExtra
from frontage.io.drawings.elevation import (
    BORDER_MM,
    LAYERS,
    TITLE_MM,
    Elevation,
    Line,
    place_on_sheet,
)
from frontage.io.files import whole_file

APP = "FRONTAGE"
"""The application of the extended data: id of an element and facts about it; of an outline also `SHIFT`."""

SHIFT, ZERO = "shift", "zero"
"""Facts of an outline: x of the drawing = x of the facade + shift, y = z of the facade + zero (m)."""

_DASHED = "FRONTAGE_DASHED"
_GAP_MM = 150.0  # on paper, between facades in model space
_TEXT_MM = 2.0
_METRES, _MILLIMETRES = 6, 4  # $INSUNITS


def write_dxf(path: Path, elevations: Sequence[Elevation]) -> None:
    """Write the elevations of a building side by side, from the first on the left, heights as y.

    Raises MissingExtra without ezdxf, FileError when the file cannot be written.
    """
    try:
        import ezdxf
    except ImportError as error:
        raise MissingExtra("writing DXF", "products") from error
    with _reproducible(ezdxf):
        doc = ezdxf.new("R2010", units=_METRES)
        scale = max(e.sheet.scale for e in elevations)
        _prepare(doc, scale)
        shift = 0.0
        for elevation in elevations:
            x0, _, x1, _ = elevation.bounds
            own = float(round(shift - x0))
            _draw(doc, elevation, own)
            _layout(doc, elevation, own)
            shift = x1 + own + _GAP_MM * scale / 1000
        doc.layouts.delete("Layout1")
        doc.classes.add_required_classes(doc.dxfversion)  # now, since their order follows hashes
        doc.classes.classes = dict(sorted(doc.classes.classes.items()))
        with whole_file(path) as temporary:
            doc.saveas(temporary)


@contextmanager
def _reproducible(ezdxf: Any) -> Iterator[None]:
    """Keep the time and random numbers out of the file."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _prepare(doc: Any, scale: int) -> None:
    """Make layers, the dashed line, the style of dimensions, and the application's name."""
    doc.appids.new(APP)
    for name, (colour, weight, about) in LAYERS.items():
        layer = doc.layers.add(name, color=colour, lineweight=weight)
        layer.description = about
    doc.layers.add("SHEET", color=7, lineweight=25).description = "border and title block, in layouts"
    doc.layers.add("VIEWPORTS", color=8).off()
    metre = scale / 1000  # metres of the facade per millimetre on paper
    dash = [v * metre for v in (4.0, 2.5, -1.5)]
    doc.linetypes.add(_DASHED, pattern=dash, description="uncertain __ __ __")
    doc.header["$LTSCALE"], doc.header["$PSLTSCALE"] = 1.0, 0
    style = {
        "dimtxt": _TEXT_MM * metre, "dimexe": 1.0 * metre, "dimexo": 1.0 * metre, "dimgap": 0.6 * metre,
        "dimtsz": 1.2 * metre, "dimdec": 3, "dimtad": 1, "dimrnd": 0.0, "dimlfac": 1.0, "dimzin": 0,
        "dimtih": 0, "dimtoh": 0, "dimscale": 1.0, "dimdsep": ord("."), "dimlunit": 2,
    }  # fmt: skip
    doc.dimstyles.new(APP, dxfattribs=style)


def _draw(doc: Any, e: Elevation, shift: float) -> None:
    space = doc.modelspace()
    if e.underlay is not None:
        image = doc.add_image_def(filename=e.underlay.path, size_in_pixel=e.underlay.pixels)
        (x, top), (w, h) = e.underlay.corner, e.underlay.size
        layer = {"layer": "ORTHO_IMAGE"}
        space.add_image(image, insert=(x + shift, top - h), size_in_units=(w, h), dxfattribs=layer)
    for line in e.lines:
        _polyline(space, line, e, shift)
    for d in e.dimensions:
        base = (d.start[0] + shift, d.at) if d.axis == "x" else (d.at + shift, d.start[1])
        ends = [(x + shift, h) for x, h in (d.start, d.end)]
        angle, layer = (0 if d.axis == "x" else 90), {"layer": "DIMENSIONS"}
        space.add_linear_dim(base, *ends, angle=angle, dimstyle=APP, dxfattribs=layer).render()
    for label in e.labels:
        _text(space, label.text, (label.at[0] + shift, label.at[1]), e.sheet.metres(_TEXT_MM), "LABELS", 4)
    right = e.bounds[2] + shift
    for level in e.levels:
        ends = [(right + e.sheet.metres(mm), level.height) for mm in (2.0, 14.0)]
        space.add_line(*ends, dxfattribs={"layer": "LEVELS"})
        text, at = f"{level.height:+.3f}  {level.name}", (ends[0][0], level.height + e.sheet.metres(0.7))
        _text(space, text, at, e.sheet.metres(_TEXT_MM), "LEVELS", 0)


def _polyline(space: Any, line: Line, e: Elevation, shift: float) -> None:
    about = {"layer": line.layer, "linetype": _DASHED if line.dashed else "BYLAYER"}
    points = [(float(x) + shift, float(h)) for x, h in line.points]
    made = space.add_lwpolyline(points, close=True, dxfattribs=about)
    placed = ((SHIFT, shift), (ZERO, e.zero)) if line.layer == "OUTLINE" else ()
    facts = [part for name, value in (*line.facts, *placed) for part in ((1000, name), (1040, value))]
    if line.tag or facts:
        made.set_xdata(APP, [(1000, line.tag), *facts])


def _text(space: Any, text: str, at: tuple[float, float], height: float, layer: str, column: int) -> None:
    """Add a text: `column` 0 = left on the base line, 4 = centred in the middle."""
    made = space.add_text(text, height=height, dxfattribs={"layer": layer})
    if column:
        made.dxf.halign, made.dxf.valign, made.dxf.align_point = 1, 2, at
    made.dxf.insert = at


def _layout(doc: Any, e: Elevation, shift: float) -> None:
    """Add a layout in mm with the facade to scale, a border and the title block."""
    (w, h), sheet = e.sheet.size, e.sheet
    name = f"{e.facade.replace('/', '_')} 1-{sheet.scale}"
    layout = doc.layouts.new(name)
    layout.page_setup(size=(w, h), margins=(0, 0, 0, 0), units="mm")
    left, low, right, high = BORDER_MM, BORDER_MM + TITLE_MM, w - BORDER_MM, h - BORDER_MM
    x0, h0, _, _ = e.bounds
    at = place_on_sheet(e)
    centre = ((left + right) / 2, (low + high) / 2)
    view = (x0 + shift + sheet.metres(centre[0] - at[0]), h0 + sheet.metres(centre[1] - at[1]))
    viewport = layout.add_viewport(
        center=centre,
        size=(right - left, high - low),
        view_center_point=view,
        view_height=sheet.metres(high - low),
    )
    viewport.dxf.layer = "VIEWPORTS"
    for box in ((left, BORDER_MM, right, high), (left, BORDER_MM, right, low)):
        corners = [(box[0], box[1]), (box[2], box[1]), (box[2], box[3]), (box[0], box[3])]
        layout.add_lwpolyline(corners, close=True, dxfattribs={"layer": "SHEET"})
    for k, text in enumerate((*e.title, sheet.words)):
        _text(layout, text, (left + 4, low - 6 - 5 * k), 2.5, "SHEET", 0)
