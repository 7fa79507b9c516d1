"""What GDAL's XML files say of a raster in the plane of a facade: `.vrt` and `.aux.xml`."""

from collections.abc import Mapping
from xml.sax.saxutils import escape, quoteattr


def place_xml(
    name: str, up: str, corner: tuple[float, float], gsd: float, metadata: Mapping[str, str]
) -> str:
    """Return the elements SRS, GeoTransform and Metadata.

    name    of the local coordinate system, `up` that of its vertical axis
    corner  m, x and height of the upper left corner; gsd m per px
    """
    (x, top), quoted = corner, name.replace('"', "'")
    srs = escape(f'LOCAL_CS["{quoted}",UNIT["metre",1],AXIS["x",EAST],AXIS["{up}",NORTH]]')
    place = ", ".join(repr(float(v)) for v in (x, gsd, 0.0, top, 0.0, -gsd))
    items = "".join(f"    <MDI key={quoteattr(k)}>{escape(v)}</MDI>\n" for k, v in metadata.items())
    return f"  <SRS>{srs}</SRS>\n  <GeoTransform>{place}</GeoTransform>\n  <Metadata>\n{items}  </Metadata>\n"
