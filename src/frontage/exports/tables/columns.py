"""The columns of the tables of a run: what each holds, and in which unit."""

from frontage.io.tables.table import Column

_WHERE = (
    Column("building", "text", "id of the building"),
    Column("address", "text", "address of the building"),
)
_ON_WALL = (*_WHERE, Column("facade", "text", "id of the facade"))
_PROVENANCE = Column("provenance", "text", "measured, pooled, inferred or given")
_SIGMA = "standard error"
BUILDINGS = (
    Column("id", "text", "id"),
    Column("address", "text", "address"),
    Column("ground", "real", "height of the ground at its foot above datum", "m"),
    Column("top", "real", "height of the upper end of its facades above datum", "m"),
    Column("facades", "whole", "number of facades"),
    Column("openings", "whole", "number of openings; empty = not looked for"),
    Column("window_to_wall", "real", "area of openings but doors, gates, passages / area of facades"),
    Column("sigma_window_to_wall", "real", _SIGMA),
    Column("plan", "text", "what its place is: its footprint, or the hull of its points"),
    Column("missing", "text", "what could not be made, and why"),
)
FACADES = (
    Column("id", "text", "id"),
    *_WHERE,
    Column("width", "real", "width of the outline", "m"),
    Column("height", "real", "height of the outline", "m"),
    Column("area", "real", "area of the outline, openings included", "m2"),
    Column("foot", "real", "height of the lower end of the outline above datum", "m"),
    Column("top", "real", "height of the upper end of the outline above datum", "m"),
    Column("bearing", "real", "direction that it faces, clockwise from grid north", "degree"),
    Column("sigma_plane", "real", "standard error of the place of its plane", "m"),
    Column("roughness", "real", "standard deviation of the points about the plane", "m"),
    Column("spacing", "real", "median distance of neighbouring points", "m"),
    Column("coverage", "real", "share of the outline with points on the wall"),
    Column("openings", "whole", "number of openings; empty = not looked for"),
    Column("doors", "whole", "number of doors, gates and passages"),
    Column("window_to_wall", "real", "area of openings but doors, gates, passages / area"),
    Column("sigma_window_to_wall", "real", _SIGMA),
    _PROVENANCE,
)
OPENINGS = (
    Column("id", "text", "id"),
    *_ON_WALL,
    Column("kind", "text", "window, door, shopfront, passage, garage, basement, other"),
    Column("shape", "text", "shape of its outline"),
    Column("floor", "whole", "storey, the ground floor is 0"),
    Column("number", "whole", "number on its floor from the left, seen from the street"),
    Column("bay", "whole", "column over all floors from the left"),
    Column("on", "text", "id of the protrusion that holds it; empty = the main wall"),
    Column("width", "real", "clear width", "m"),
    Column("height", "real", "clear height", "m"),
    Column("area", "real", "area of the outline", "m2"),
    Column("sill", "real", "height of the lower border above datum", "m"),
    Column("head", "real", "height of the upper border above datum", "m"),
    Column("depth", "real", "depth of the frame behind the wall", "m"),
    *(Column(f"sigma_{side}", "real", _SIGMA, "m") for side in ("left", "bottom", "right", "top")),
    *(Column(f"sigma_{side}", "real", _SIGMA, "m") for side in ("width", "height", "depth")),
    Column("sigma_area", "real", _SIGMA, "m2"),
    Column("mullions", "whole", "number of upright bars; empty = not resolved or not looked for"),
    Column("transoms", "whole", "number of level bars; empty = not resolved or not looked for"),
    Column("frame_width", "real", "how far the frame reaches into the opening", "m"),
    Column("bar_confidence", "real", "probability that the layout of bars is the true one"),
    _PROVENANCE,
    Column("confidence", "real", "probability that the opening exists"),
    Column("photos", "text", "photos that show it, separated by semicolons"),
)
PROTRUSIONS = (
    Column("id", "text", "id"),
    *_ON_WALL,
    Column("kind", "text", "balcony, cornice, oriel, ..."),
    Column("width", "real", "width of its outline", "m"),
    Column("height", "real", "height of its outline", "m"),
    Column("foot", "real", "height of its lower border above datum", "m"),
    Column("top", "real", "height of its upper border above datum", "m"),
    Column("front", "real", "depth of its front behind the wall, negative = before it", "m"),
    Column("sigma_border", "real", _SIGMA, "m"),
    Column("sigma_front", "real", _SIGMA, "m"),
    _PROVENANCE,
    Column("confidence", "real", "probability that it exists"),
)
BARS = (
    Column("opening", "text", "id of the opening that it divides"),
    *_ON_WALL,
    Column("axis", "text", "vertical (mullion) or horizontal (transom)"),
    Column("position", "real", "x of the facade, or height above datum, of the centre line", "m"),
    Column("width", "real", "width", "m"),
    Column("sigma_position", "real", _SIGMA, "m"),
    Column("sigma_width", "real", _SIGMA, "m"),
    _PROVENANCE,
)
PHOTOS = (
    Column("photo", "text", "name of the photo"),
    Column("camera", "text", "camera model"),
    Column("columns", "whole", "width", "px"),
    Column("rows", "whole", "height", "px"),
    Column("bearing", "real", "direction of view, clockwise from grid north", "degree"),
    Column("pitch", "real", "direction of view above the horizon", "degree"),
    *(Column(f"sigma_{axis}", "real", "standard error of the position; empty = not known", "m")
      for axis in ("x", "y", "z")),
    Column("provenance", "text", "given, or measured by the stage orient"),
)  # fmt: skip
STATIONS = (Column("number", "whole", "running number of the position of the scanner"),)
