"""City models made to harm: one sentence each, no crash, no silent nonsense."""

import json
import resource
import sqlite3
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import shapely

from city_files import LOCAL, house, write
from footprint_files import geojson, geopackage
from frontage.errors import CrsError, FileError
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.io.citymodels.wkb import polygons_of
from io_files import UTM
from shape_files import FACES, city, lod2_surface, members, polygon

DEEP = 50_000
XLINK = "xlink:href"


def with_geometry(path: Path, wkb: bytes) -> Path:
    geopackage(path)
    with sqlite3.connect(path) as database:
        database.execute("UPDATE footprints SET geom = ?", (b"GP\0\1" + struct.pack("<i", 25832) + wkb,))
    database.close()
    return path


def test_nested_collections_end_in_a_sentence_not_in_a_signal(tmp_path: Path) -> None:
    nested = struct.pack("<BII", 1, 7, 1) * DEEP + struct.pack("<BII", 1, 7, 0)
    path = with_geometry(tmp_path / "m.gpkg", nested)
    call = f"from frontage.io.citymodels.read import read_city_model as r; r({str(path)!r})"
    run = subprocess.run([sys.executable, "-c", call], capture_output=True, text=True, timeout=60)
    assert run.returncode == 1
    assert "collections that are nested too deeply" in run.stderr.splitlines()[-1]


def test_polygons_in_collections_are_found() -> None:
    square = shapely.box(0, 0, 1, 1)
    both = shapely.GeometryCollection([shapely.Point(0, 0), shapely.MultiPolygon([square]), square])
    for shape, number in ((square, 1), (both, 2), (shapely.force_3d(both), 2), (shapely.Polygon(), 0)):
        for dialect in ("iso", "extended"):
            for order in (0, 1):
                wkb = shapely.to_wkb(shape, flavor=dialect, byte_order=order)
                assert len(polygons_of(wkb)) == number
    assert len(polygons_of(shapely.to_wkb(shapely.set_srid(square, 25832), include_srid=True))) == 1


@pytest.mark.parametrize("cut", [0, 1, 4, 8, 12, 40, 92])
def test_geometries_cut_short_are_told(cut: int) -> None:
    with pytest.raises(ValueError, match="cut short"):
        polygons_of(shapely.to_wkb(shapely.box(0, 0, 1, 1))[:cut])


@pytest.mark.parametrize(
    ("wkb", "told"),
    [
        (struct.pack("<BII", 1, 7, 2**32 - 1), "cut short"),
        (struct.pack("<BII", 1, 3, 2**32 - 1), "cut short"),
        (struct.pack("<BII", 1, 2, 2**32 - 1), "cut short"),
        (struct.pack("<BII", 1, 10, 0), "curved or unknown"),
        (struct.pack("<BII", 1, 99, 0), "curved or unknown"),
        (struct.pack("<BII", 7, 3, 0), "byte order"),
    ],
)
def test_counts_and_kinds_are_not_believed(wkb: bytes, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        polygons_of(wkb)


def placed(x: float, y: float, crs: str | None) -> dict[str, Any]:
    """A footprint that begins at a point."""
    table = geojson(height=9)
    step = 1e-4 if crs is None else 1.0
    ring = [[x, y], [x + 9 * step, y], [x + 9 * step, y + 9 * step], [x, y]]
    table["features"][0]["geometry"]["coordinates"] = [ring]
    table["crs"] = {"type": "name", "properties": {"name": crs}}
    return table


@pytest.mark.parametrize(
    ("x", "y", "crs"),
    [
        (11.0, 95.0, None),
        (11.0, -90.5, None),
        (500.0, 48.0, None),
        (1e308, 5.4e6, "EPSG:25832"),
        (678000.0, 5.4e9, "EPSG:25832"),
        (678e6, 5403e6, "EPSG:25832"),  # millimetres
    ],
)
def test_coordinates_outside_the_domain_of_their_crs_are_refused(
    tmp_path: Path, x: float, y: float, crs: str | None
) -> None:
    path = write(tmp_path / "m.geojson", placed(x, y, crs))
    for world in (None, UTM):
        with pytest.raises((CrsError, FileError)) as told:
            read_city_model(path, world)
        assert "m.geojson" in str(told.value) and "domain of their CRS" in str(told.value)


def test_one_footprint_outside_the_domain_is_found_among_others(tmp_path: Path) -> None:
    table = placed(11.4, 48.7, None)
    table["features"].append(placed(11.4, 95.0, None)["features"][0])
    with pytest.raises(CrsError, match=r"\(11\.4, 95, .*latitude|\(11\.4\d*, 95.*domain"):
        read_city_model(write(tmp_path / "m.geojson", table))


def test_local_coordinates_have_a_limit_too(tmp_path: Path) -> None:
    far = house("A", 1e12)
    path = write_cityjson(tmp_path / "m.city.json", [far], LOCAL, "t")
    with pytest.raises(CrsError, match="domain"):
        read_city_model(path, LOCAL)


def test_a_bow_tie_is_told_and_divided(tmp_path: Path) -> None:
    table = geojson(height=9)
    x, y = 678000, 5403000
    bow = [[x, y], [x + 10, y + 10], [x + 10, y], [x, y + 10], [x, y]]
    table["features"][0]["geometry"]["coordinates"] = [bow]
    model = read_city_model(write(tmp_path / "m.geojson", table), UTM)
    (problem,) = model.problems
    assert "crosses itself (2 parts made of it)" in problem.message
    (building,) = model.buildings
    (flat,) = building.level("0") or [s for s in building.shells if s.lod == "0"]
    areas = [shapely.Polygon(s.ring[:, :2]) for s in flat.surfaces]
    assert all(p.is_valid for p in areas) and [p.area for p in areas] == pytest.approx([25.0, 25.0])


def test_references_that_multiply_end_in_a_sentence(tmp_path: Path) -> None:
    def surface(name: str, inside: str) -> str:
        return f'<gml:MultiSurface gml:id="{name}">{inside}</gml:MultiSurface>'

    levels = "".join(surface(f"L{k}", f'<gml:surfaceMember {XLINK}="#L{k + 1}"/>' * 8) for k in range(1, 30))
    last = surface("L30", members(polygon(FACES[0])))
    start = surface("L0", f'<gml:surfaceMember {XLINK}="#L1"/>')
    inside = "".join(
        f"<bldg:boundedBy><bldg:WallSurface><bldg:lod2MultiSurface>{g}</bldg:lod2MultiSurface>"
        "</bldg:WallSurface></bldg:boundedBy>"
        for g in (start, *levels.replace("</gml:MultiSurface><", "</gml:MultiSurface>\n<").split("\n"), last)
    )
    path = write(tmp_path / "m.gml", city(inside))
    started = time.monotonic()
    try:
        read_city_model(path, LOCAL)
    except FileError as told:
        assert len(str(told)) < 400
    assert time.monotonic() - started < 10


@pytest.mark.parametrize(
    "text",
    [
        '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/hostname">]>{}',
        '<?xml version="1.0"?><!DOCTYPE a SYSTEM "http://127.0.0.1:9/a.dtd">{}',
        '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY % p SYSTEM "http://127.0.0.1:9/"> %p;]>{}',
    ],
)
def test_document_types_are_refused(tmp_path: Path, text: str) -> None:
    inside = city(lod2_surface(members(polygon(FACES[0]))))
    path = write(
        tmp_path / "m.gml", text.format(inside[inside.index("<core:") if "<core:" in inside else 0 :])
    )
    with pytest.raises(FileError, match="document type declaration"):
        read_city_model(path, UTM)


def test_deeply_nested_json_is_told(tmp_path: Path) -> None:
    deep = "[" * 100_000 + "]" * 100_000
    text = json.dumps(geojson())[:-1] + f', "x": {deep}}}'
    with pytest.raises(FileError, match="nested too deeply"):
        read_city_model(write(tmp_path / "m.geojson", text), UTM)


@pytest.mark.parametrize("writer", [write_citygml, write_cityjson])
def test_a_full_disk_is_told_and_the_old_file_stays(tmp_path: Path, writer: Any) -> None:
    path = writer(tmp_path / "m.file", [house("A", 0.0)], LOCAL, "t")
    before = path.read_bytes()
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, most))
    try:
        with pytest.raises(FileError, match="cannot be written") as told:
            writer(path, [house("A", 0.0), house("B", 20.0)], LOCAL, "t")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]
    assert told.value.code == "I104"
