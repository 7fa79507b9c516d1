"""Writes a project of QGIS (`.qgz`: a ZIP with one XML file), as QGIS 3.22 writes and reads it."""

import io
import zipfile
from pathlib import Path

from lxml import etree
from lxml.builder import E

from frontage.io.crs import crs_text, horizontal, parse_crs
from frontage.io.files import whole_file
from frontage.io.qgis.plates import layout
from frontage.io.qgis.project import Box, Group, Layer, QgisProject
from frontage.io.qgis.symbols import labels, raster_pipe, renderer

_VERSION = "3.22.0"
_DOCTYPE = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>"
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same run gives the same bytes, so the time of writing is not kept
_FACADE, _LOCAL = "Plane of a facade (x to the right, height up)", "Local metres"
_METRES = (
    'ENGCRS["{0}",EDATUM["{0}"],CS[Cartesian,2],AXIS["x",east,ORDER[1],LENGTHUNIT["metre",1]],'
    'AXIS["{1}",north,ORDER[2],LENGTHUNIT["metre",1]]]'
)


def write_qgis(path: Path, project: QgisProject) -> None:
    """Write a project; paths in it are relative to the file.

    Raises FileError when the file cannot be written, CrsError for an unknown CRS.
    """
    text = etree.tostring(project_xml(project), pretty_print=True, encoding="UTF-8", doctype=_DOCTYPE)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        entry = zipfile.ZipInfo(f"{path.stem}.qgs", _EPOCH)
        entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
        archive.writestr(entry, text)
    with whole_file(path) as temporary:
        temporary.write_bytes(packed.getvalue())


def project_xml(project: QgisProject) -> etree._Element:
    """Return the root element of the project."""
    layers = {layer.key: layer for layer in project.layers}
    root = E.qgis(E.title(project.title), E.projectCrs(_system(project.crs)), version=_VERSION,
                  projectname=project.title)  # fmt: skip
    root.append(E("layer-tree-group", *(_group(group) for group in project.groups)))
    if project.extent is not None:
        root.append(_canvas(project.extent, project.crs))
        full = E.DefaultViewExtent(_system(project.crs), **_corners(project.extent))
        root.append(E.ProjectViewSettings(E.Scales(), full, UseProjectScales="0"))
    root.append(E.layerorder(*(E.layer(id=key) for key in layers)))
    root.append(E.projectlayers(*(_layer(layer, project.crs) for layer in layers.values())))
    root.append(_properties())
    root.append(_metadata(project))
    root.append(E.Layouts(*(layout(plate, layers, _plane()) for plate in project.plates)))
    return root


def _group(group: Group) -> etree._Element:
    items = [_group(item) if isinstance(item, Group) else _leaf(item) for item in group.items]
    return E(
        "layer-tree-group",
        *items,
        name=group.name,
        checked=_checked(group.shown),
        expanded="1" if group.shown else "0",
    )


def _leaf(layer: Layer) -> etree._Element:
    facts = {"id": layer.key, "name": layer.name, "source": layer.source, "providerKey": layer.provider}
    return E("layer-tree-layer", checked=_checked(layer.shown), expanded="0", **facts)


def _layer(layer: Layer, crs: str | None) -> etree._Element:
    """Return the element `maplayer`; `crs` is that of layers that are not upright."""
    system = _plane() if layer.upright else _system(crs)
    made = E.maplayer(E.id(layer.key), E.datasource(layer.source), E.layername(layer.name), E.srs(system))
    made.append(E.provider(layer.provider, **({} if layer.look is None else {"encoding": "UTF-8"})))
    if layer.look is None:
        made.set("type", "raster")
        made.append(raster_pipe(layer))
        return made
    made.set("type", "vector")
    made.set("geometry", layer.shape)
    made.set("labelsEnabled", "1" if layer.look.label else "0")
    made.append(renderer(layer.look, layer.shape))
    if layer.look.label:
        made.append(labels(layer.look))
    return made


def _canvas(extent: Box, crs: str | None) -> etree._Element:
    """Return what the window of the map shows first."""
    corners = E.extent(*(E(name, value) for name, value in _corners(extent).items()))
    return E.mapcanvas(E.units("meters"), corners, E.rotation("0"), E.destinationsrs(_system(crs)),
                       name="theMapCanvas", annotationsVisible="1")  # fmt: skip


def _corners(extent: Box) -> dict[str, str]:
    return dict(zip(("xmin", "ymin", "xmax", "ymax"), (repr(float(v)) for v in extent), strict=True))


def _properties() -> etree._Element:
    """Return the settings: paths are relative, lengths are measured in metres in the plane of the map."""
    return E.properties(
        E.Paths(E.Absolute("false", type="bool")),
        E.SpatialRefSys(E.ProjectionsEnabled("1", type="int")),
        E.Measure(E.Ellipsoid("NONE", type="QString")),
        E.Measurement(E.DistanceUnits("meters", type="QString"), E.AreaUnits("m2", type="QString")),
    )


def _metadata(project: QgisProject) -> etree._Element:
    """Return what the properties of the project tell of it: its title, and what it leaves out."""
    about = f"Left out: {' '.join(project.left_out)}" if project.left_out else ""
    return E.projectMetadata(E.title(project.title), E.abstract(about))


def _plane() -> etree._Element:
    """Return the element `spatialrefsys` of the planes of facades."""
    return _spatialrefsys(_METRES.format(_FACADE, "height"), "", _FACADE)


def _system(crs: str | None) -> etree._Element:
    """Return the element `spatialrefsys` of the horizontal part of a CRS; of local metres without one."""
    if crs is None:
        return _spatialrefsys(_METRES.format(_LOCAL, "y"), "", _LOCAL)
    flat = horizontal(parse_crs(crs))
    code = crs_text(flat)
    return _spatialrefsys(flat.to_wkt(), code if code.startswith("EPSG:") else "", flat.name)


def _spatialrefsys(wkt: str, code: str, name: str) -> etree._Element:
    return E.spatialrefsys(
        E.wkt(wkt), E.proj4(), E.srsid("0"), E.srid(code.removeprefix("EPSG:") or "0"), E.authid(code),
        E.description(name), E.projectionacronym(), E.ellipsoidacronym(), E.geographicflag("false"),
    )  # fmt: skip


def _checked(shown: bool) -> str:
    return "Qt::Checked" if shown else "Qt::Unchecked"
