"""A GIS project of a run: the plan, the elevations with their ortho-images, and a sheet per facade."""

from collections.abc import Mapping, Sequence

import shapely

from frontage.exports.elevations import UNCERTAIN_M, bounds_of, title_block
from frontage.exports.survey import Survey, SurveyedBuilding
from frontage.io.drawings.elevation import sheet_for
from frontage.io.qgis.project import Box, Colour, Group, Layer, Look, Plate, QgisProject, Shape
from frontage.io.tables.table import Table, find
from frontage.model import Elements, Facade
from frontage.model.opening import OpeningKind

_KINDS: dict[OpeningKind, Colour] = {
    OpeningKind.WINDOW: (0, 60, 180), OpeningKind.DOOR: (190, 30, 20), OpeningKind.SHOPFRONT: (0, 130, 140),
    OpeningKind.PASSAGE: (120, 90, 40), OpeningKind.GARAGE: (190, 100, 0),
    OpeningKind.BASEMENT: (110, 60, 150),
}  # fmt: skip
_COLOURS = tuple((str(kind), colour) for kind, colour in _KINDS.items())
_GREY, _DARK, _GREEN = (120, 120, 120), (30, 30, 30), (0, 120, 60)
_VAGUE = "\"provenance\" = 'inferred' or not coalesce({}, false)"
_VAGUE_OPENING = _VAGUE.format(
    " and ".join(f'"sigma_{side}" <= {UNCERTAIN_M}' for side in ("left", "bottom", "right", "top"))
)
_VAGUE_PROTRUSION = _VAGUE.format(f'"sigma_border" <= {UNCERTAIN_M}')
_SHORT = "regexp_replace(\"id\", '^.*/', '')"  # the last part of an id
_PLAN: tuple[tuple[str, Shape, Look], ...] = (
    ("stations", "Point", Look((200, 0, 120), 2.4, label="\"number\"")),
    ("photos", "Point", Look((230, 140, 0), 4.0, turned="bearing")),
    ("openings", "Line", Look(_DARK, 1.0, by="kind", colours=_COLOURS)),
    ("protrusions", "Line", Look(_GREEN, 0.6)),
    ("facades", "Line", Look(_DARK, 0.4, label="\"id\"")),
    ("buildings", "Polygon", Look(_GREY, 0.2, (232, 228, 218), label="coalesce(\"address\", \"id\")")),
)  # fmt: skip
_UPRIGHT: tuple[tuple[str, str, Look], ...] = (
    (
        "openings",
        "facade",
        Look(_DARK, 0.35, by="kind", colours=_COLOURS, label=_SHORT, dashed=_VAGUE_OPENING),
    ),
    ("bars", "facade", Look(_GREY, 0.13)),
    ("protrusions", "facade", Look(_GREEN, 0.25, dashed=_VAGUE_PROTRUSION)),
    ("facades", "id", Look(_DARK, 0.5)),
)
_VIEW_MARGIN = 0.1  # of the extent of the facades, around them in the first view


def gis_project(
    survey: Survey, tables: Sequence[Table], pictures: Mapping[str, bool], datum: str
) -> QgisProject:
    """Return the project of a run, whose files lie beside it in `products`.

    tables    those of `survey_tables`, which `frontage.gpkg` holds
    pictures  facades with a raster `rasters/B07_F1.vrt`, and whether there is one of their depths
    datum     what heights refer to, such as "above DHHN2016 height"
    """
    plan = tuple(
        Layer(f"plan_of_{name}", name.capitalize(), _source(name), shape, look) for name, shape, look in _PLAN
    )
    walls = [(b, facade, elements) for b in survey.buildings for facade, elements in b.fronts]
    groups = tuple(_elevation(facade.id, pictures.get(facade.id)) for _, facade, _ in walls)
    plates = (
        _plate(b, facade, elements, datum, group)
        for (b, facade, elements), group in zip(walls, groups, strict=True)
    )
    return QgisProject(
        title="Frontage",
        crs=survey.world.crs,
        groups=(Group("Plan", plan), Group("Elevations", groups, shown=False)),
        plates=tuple(plates),
        extent=_extent(tables),
        left_out=survey.left_out,
    )


def _plate(b: SurveyedBuilding, facade: Facade, elements: Elements | None, datum: str, group: Group) -> Plate:
    """Return the sheet of a facade, with paper and scale as in its drawing."""
    bounds = bounds_of(facade, elements or Elements(facade.id, ()))
    sheet = sheet_for(bounds[2] - bounds[0], bounds[3] - bounds[1])
    pictured = any(layer.shape == "Raster" for layer in group.layers)
    head, *about = title_block(b, facade, elements, datum, pictured=pictured)
    shown = tuple(layer.key for layer in group.layers if layer.shown)
    return Plate(facade.id, sheet, bounds, shown, (f"{head}. {sheet.words}", *about))


def _elevation(facade: str, relief: bool | None) -> Group:
    """Return the layers in the plane of a facade: lines over the picture, and depths if there is relief.

    relief  None = there is no picture
    """
    stem = facade.replace("/", "_")
    lines = [
        Layer(f"facade_{stem}_{name}", name.capitalize(), _source(f"{name[:-1]}_elevations", column, facade),
              "Polygon", look, upright=True)
        for name, column, look in _UPRIGHT
    ]  # fmt: skip
    rasters = [("ortho", "Ortho-image", "")] if relief is not None else []
    rasters += [("depth", "Depth", "_depth")] if relief else []
    pictures = (
        Layer(f"facade_{stem}_{key}", name, f"./rasters/{stem}{ending}.vrt", "Raster", depths=key == "depth",
              upright=True, shown=key == "ortho")
        for key, name, ending in rasters
    )  # fmt: skip
    return Group(facade, (*lines, *pictures), shown=False)


def _source(layer: str, column: str = "", value: str = "") -> str:
    """Return where the features of a layer of the GeoPackage are, only those with a value in a column."""
    only = f"|subset=\"{column}\" = '{value}'" if column else ""
    return f"./frontage.gpkg|layername={layer}{only}"


def _extent(tables: Sequence[Table]) -> Box | None:
    """Return the box of all facades and buildings in the world with a margin, None without any."""
    places = [g for name in ("facades", "buildings") for g in find(tables, name).geometries if g is not None]
    if not places:
        return None
    x0, y0, x1, y1 = shapely.total_bounds(places).tolist()
    margin = _VIEW_MARGIN * max(x1 - x0, y1 - y0)
    return x0 - margin, y0 - margin, x1 + margin, y1 + margin
