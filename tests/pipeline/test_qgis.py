"""The project for QGIS shows files that exist, in the right places, and measures in metres."""

import json
import os
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyogrio
import pytest
import rasterio
import shapely
from lxml import etree

from frontage.io.drawings.elevation import BORDER_MM, TITLE_MM, Sheet
from frontage.io.qgis.project import Group, Layer, Look, Plate, QgisProject
from frontage.io.qgis.write import project_xml
from frontage.pipeline.run import run_stage
from frontage.pipeline.store.store import Store

_QGIS_PYTHON = "/usr/bin/python3"  # the one that distributions install QGIS for


def document(out: Path) -> etree._Element:
    with zipfile.ZipFile(out / "products" / "frontage.qgz") as archive:
        assert archive.namelist() == ["frontage.qgs"]
        return etree.fromstring(archive.read("frontage.qgs"))


@pytest.fixture(scope="module")
def project(simulated_run: Path) -> etree._Element:
    return document(simulated_run)


def source_of(layer: etree._Element) -> tuple[str, str, str]:
    """The file of a layer, its layer in there, and which of its features are chosen."""
    path, *parts = str(layer.findtext("datasource")).split("|")
    told = dict(part.split("=", 1) for part in parts)
    return path, told.get("layername", ""), told.get("subset", "")


def features(out: Path, layer: etree._Element) -> Any:
    path, name, chosen = source_of(layer)
    assert path == "./frontage.gpkg"
    return pyogrio.read_dataframe(out / "products" / path, layer=name, where=chosen or None)


def box_of(element: etree._Element) -> shapely.Polygon:
    return shapely.box(*(float(element.get(side, "")) for side in ("xmin", "ymin", "xmax", "ymax")))


def test_every_layer_is_there_and_every_leaf_of_the_tree_is_a_layer(
    simulated_run: Path, project: etree._Element
) -> None:
    layers = {str(layer.findtext("id")): layer for layer in project.iter("maplayer")}
    leaves = [leaf.get("id") for leaf in project.iter("layer-tree-layer")]
    assert sorted(leaves) == sorted(layers) and len(set(leaves)) == len(leaves)
    assert all(len(key) > 10 for key in layers)  # QGIS renames shorter ones
    facades = Store(simulated_run).facade_ids()
    assert len(layers) == 6 + 6 * len(facades)
    kinds = {"Point": "marker", "Line": "line", "Polygon": "fill"}
    for layer in layers.values():
        if layer.get("type") == "raster":
            with rasterio.open(simulated_run / "products" / source_of(layer)[0]) as raster:
                assert raster.count in (1, 4)
            continue
        frame = features(simulated_run, layer)
        shapes = {str(kind).replace("String", "") for kind in frame.geometry.geom_type}
        assert shapes <= {layer.get("geometry")}
        symbols = layer.findall("renderer-v2/symbols/symbol")
        assert {s.get("type") for s in symbols} == {kinds[str(layer.get("geometry"))]}
        named = {s.get("name") for s in symbols}
        assert {c.get("symbol") for c in layer.iter("category")} <= named
        for text in layer.iter("text-style"):
            assert str(text.get("fieldName")).split('"')[1] in frame.columns
        if column := layer.find("renderer-v2").get("attr"):  # type: ignore[union-attr]
            assert set(frame[column]) <= {c.get("value") for c in layer.iter("category")}


def test_layouts_show_their_facade_at_a_round_scale(simulated_run: Path, project: etree._Element) -> None:
    layers = {str(layer.findtext("id")): layer for layer in project.iter("maplayer")}
    openings = json.loads((simulated_run / "facades" / "B01_F1" / "openings.json").read_text())
    layouts = project.findall("Layouts/Layout")
    assert [layout.get("name") for layout in layouts] == Store(simulated_run).facade_ids()
    (layout,) = (x for x in layouts if x.get("name") == "B01/F1")
    (chart,) = (x for x in layout.iter("LayoutItem") if x.get("type") == "65639")
    shown, paper = box_of(chart.find("Extent")), str(chart.get("size")).split(",")  # type: ignore[arg-type]
    x0, y0, x1, y1 = shown.bounds
    for metres, millimetres in ((x1 - x0, paper[0]), (y1 - y0, paper[1])):
        assert metres * 1000 / float(millimetres) == pytest.approx(50, abs=1e-9)
    seen = [layers[str(layer.text)] for layer in chart.iter("Layer")]
    assert all("ENGCRS" in str(layer.findtext("srs/spatialrefsys/wkt")) for layer in seen)
    zero = Store(simulated_run).facade("B01/F1").height_of_zero
    found = {row["id"]: row["geometry"] for row in features(simulated_run, seen[0]).to_dict("records")}
    assert found.keys() == {o["id"] for o in openings}
    for o in openings:
        ring = shapely.get_coordinates(found[o["id"]])[:-1]
        np.testing.assert_allclose(ring, np.array(o["outline"]) + np.array([0, zero]), atol=1e-4, rtol=0)
        assert shown.contains(found[o["id"]])
    with rasterio.open(simulated_run / "products" / source_of(seen[-1])[0]) as raster:
        assert shown.contains(shapely.box(*raster.bounds).buffer(-0.5))


def test_the_first_view_holds_the_facades(simulated_run: Path, project: etree._Element) -> None:
    view = box_of(project.find("ProjectViewSettings/DefaultViewExtent"))  # type: ignore[arg-type]
    lines = pyogrio.read_dataframe(simulated_run / "products" / "frontage.gpkg", layer="facades")
    assert all(view.contains(line) for line in lines.geometry)
    assert view.area < 20 * lines.union_all().envelope.buffer(1.0).area
    code = Store(simulated_run).world().crs
    assert code is not None and project.findtext("projectCrs/spatialrefsys/authid") == code.split("+")[0]
    assert project.findtext("properties/SpatialRefSys/ProjectionsEnabled") == "1"
    assert project.findtext("properties/Paths/Absolute") == "false"


def test_the_same_run_gives_the_same_project_and_pictures_may_be_absent(
    simulated_run: Path, tmp_path: Path
) -> None:
    out = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    path = out / "products" / "frontage.qgz"
    before = path.read_bytes()
    path.unlink()
    run_stage(out, "qgis")
    assert path.read_bytes() == before
    (out / ".done" / "ortho.B01.json").unlink()
    run_stage(out, "qgis")
    again = document(out)
    assert not [layer for layer in again.iter("maplayer") if layer.get("type") == "raster"]
    texts = [str(item.get("labelText")) for item in again.iter("LayoutItem")]
    assert any("Left out: the ortho-image" in text for text in texts)


def test_a_sheet_at_any_scale_and_a_run_without_crs() -> None:
    look = Look((0, 0, 0), 0.3, label='"id"')
    layer = Layer("layer_of_all", "All", "./a.gpkg|layername=all", "Polygon", look, upright=True)
    sheet = Sheet("A0", (1189.0, 841.0), 2000)
    plate = Plate("Long wall", sheet, (-900.0, 10.0, 900.0, 60.0), (layer.key,), ("Long wall",))
    root = project_xml(QgisProject("Run", None, (Group("Elevations", (layer,)),), (plate,), None))
    (chart,) = (x for x in root.iter("LayoutItem") if x.get("type") == "65639")
    x0, y0, x1, y1 = box_of(chart.find("Extent")).bounds  # type: ignore[arg-type]
    assert x1 - x0 == pytest.approx((1189 - 2 * BORDER_MM) * 2, abs=1e-9)
    assert y1 - y0 == pytest.approx((841 - 2 * BORDER_MM - TITLE_MM) * 2, abs=1e-9)
    assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx((0, 35))
    assert root.find("mapcanvas") is None
    assert "ENGCRS" in str(root.findtext("projectCrs/spatialrefsys/wkt"))


def _has_qgis() -> bool:
    command = [_QGIS_PYTHON, "-c", "import qgis.core"]
    return Path(_QGIS_PYTHON).exists() and subprocess.run(command, capture_output=True).returncode == 0


@pytest.mark.skipif(not _has_qgis(), reason="QGIS is not installed (Debian: python3-qgis)")
def test_qgis_opens_the_project(simulated_run: Path, tmp_path: Path) -> None:
    script = Path(__file__).parents[1] / "opened_in_qgis.py"
    path = simulated_run / "products" / "frontage.qgz"
    quiet = {"QT_QPA_PLATFORM": "offscreen", "XDG_RUNTIME_DIR": str(tmp_path), "HOME": str(tmp_path)}
    command = [_QGIS_PYTHON, script, path, tmp_path]
    environment = {"PATH": os.environ["PATH"], **quiet}
    answer = subprocess.run(command, capture_output=True, check=True, env=environment, timeout=120)
    told = json.loads(answer.stdout)
    crs = str(Store(simulated_run).world().crs).split("+")[0]
    assert told["opened"] and told["crs"] == crs
    assert all(layer["valid"] and layer["units"] == "meters" for layer in told["layers"].values())
    plan = [key for key in told["layers"] if key.startswith("plan_of_")]
    assert sorted(told["visible"]) == sorted(plan) and len(plan) == 6
    assert all(told["layers"][key]["crs"] == crs for key in plan)
    openings = json.loads((simulated_run / "facades" / "B01_F1" / "openings.json").read_text())
    elevation = told["layers"]["facade_B01_F1_openings"]
    assert elevation["features"] == len(openings) and elevation["labels"]
    assert elevation["renderer"] == "QgsCategorizedSymbolRenderer"
    for name, layout in told["layouts"].items():
        assert layout["scale"] == pytest.approx(50, abs=1e-3) and layout["bar"] == [True, "m", 1.0]
        assert len(layout["layers"]) == 5 and layout["exported"]
        picture = cv2.imread(str(tmp_path / f"{name.replace('/', '_')}.png"))
        assert picture is not None and (picture < 200).any(axis=2).mean() > 0.05  # not an empty page
