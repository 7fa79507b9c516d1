"""Tables of a run: every format gives back the openings of `openings.json`."""

import csv
import io
import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pyogrio
import pyproj
import pytest
import shapely
from PIL import Image

import frontage.pipeline.products as products
from frontage.errors import InputError, MissingExtra
from frontage.io.tables.geopackage import write_geopackage
from frontage.io.tables.table import Column, Table
from frontage.pipeline.run import run_stage
from frontage.pipeline.store.store import Store
from frontage.pipeline.survey import gather_survey
from frontage.queries.runfolder import open_run

TOLERANCE_M = 1e-4


@pytest.fixture(scope="module")
def truth(simulated_run: Path) -> dict[str, dict[str, Any]]:
    """The records of `openings.json`, by id."""
    files = (simulated_run / "facades").glob("*/openings.json")
    found = {o["id"]: o for file in files for o in json.loads(file.read_text())}
    assert len(found) > 3
    return found


def check(row: dict[str, Any], outline: Any, record: dict[str, Any]) -> None:
    """A row and its outline in the world against a record of `openings.json`."""
    world, (x, z) = np.array(record["outline_world"]), np.array(record["outline"]).T
    np.testing.assert_allclose(outline, world, atol=TOLERANCE_M, rtol=0)
    expected = {
        "width": np.ptp(x), "height": np.ptp(z), "sill": world[:, 2].min(), "head": world[:, 2].max(),
        "depth": record["depth"], "floor": record["floor"], "bay": record["bay"],
        "confidence": record["confidence"], **{f"sigma_{k}": v for k, v in record["sigma"].items()},
    }  # fmt: skip
    for name, value in expected.items():
        got = None if row[name] in ("", None) or row[name] != row[name] else float(row[name])
        assert (got is None) == (value is None), name
        assert value is None or got == pytest.approx(value, abs=TOLERANCE_M), name
    assert (row["kind"], row["provenance"]) == (record["kind"], record["provenance"])


def ring(polygon: Any) -> Any:
    return shapely.get_coordinates(polygon, include_z=True)[:-1]


def test_geopackage_gives_back_the_openings(simulated_run: Path, truth: dict[str, Any]) -> None:
    path = simulated_run / "products" / "frontage.gpkg"
    layers = dict(pyogrio.list_layers(path))
    assert layers == {
        "buildings": "Polygon", "facades": "LineString Z", "facade_outlines": "Polygon Z",
        "openings": "LineString Z", "opening_outlines": "Polygon Z", "protrusions": "LineString Z",
        "protrusion_outlines": "Polygon Z", "photos": "Point Z", "stations": "Point Z",
        "facade_elevations": "Polygon", "opening_elevations": "Polygon", "protrusion_elevations": "Polygon",
        "bar_elevations": "Polygon",
    }  # fmt: skip
    frame = pyogrio.read_dataframe(path, layer="opening_outlines")
    assert frame.crs == pyproj.CRS(Store(simulated_run).world().crs)
    assert set(frame["id"]) == truth.keys()
    for row in frame.to_dict("records"):
        check(row, ring(row["geometry"]), truth[row["id"]])
    lines = pyogrio.read_dataframe(path, layer="openings")
    for line, outline in zip(lines.geometry, frame.geometry, strict=True):
        low = ring(outline)[:, 2].min()
        np.testing.assert_allclose(shapely.get_coordinates(line, include_z=True)[:, 2], low, atol=1e-3)
        assert outline.envelope.buffer(1e-6).contains(shapely.force_2d(line))


def test_geopackage_obeys_the_standard(simulated_run: Path) -> None:
    path = simulated_run / "products" / "frontage.gpkg"
    with closing(sqlite3.connect(path)) as database:
        assert database.execute("PRAGMA application_id").fetchone() == (0x47504B47,)
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert database.execute("PRAGMA foreign_key_check").fetchall() == []
        systems = {row[0] for row in database.execute("SELECT srs_id FROM gpkg_spatial_ref_sys")}
        assert {-1, 0, 4326} < systems
        x0, x1 = database.execute(
            "SELECT min_x, max_x FROM gpkg_contents WHERE table_name = 'facades'"
        ).fetchone()
        described = dict(
            database.execute(
                "SELECT column_name, description FROM gpkg_data_columns WHERE table_name = 'openings'"
            )
        )
    assert pyogrio.read_info(path, layer="facades")["total_bounds"][::2] == (x0, x1)
    assert described["sill"] == "height of the lower border above datum (m)"


@pytest.mark.parametrize("crs", ["EPSG:25832+7837", "EPSG:4978", None])
def test_geopackage_in_any_system(tmp_path: Path, crs: str | None) -> None:
    place = shapely.Point(691000.0, 5336000.0, 512.5)
    table = Table("at", "", (Column("n", "whole", ""),), ((1,), (2,)), "POINT", (place, None))
    write_geopackage(tmp_path / "a.gpkg", [table], crs)
    frame = pyogrio.read_dataframe(tmp_path / "a.gpkg")
    assert frame.geometry[0] == place and frame.geometry[1] is None and frame["n"].tolist() == [1, 2]
    if crs == "EPSG:25832+7837":
        assert frame.crs.sub_crs_list[0].to_epsg() == 25832


def test_geoparquet_and_frames_give_back_the_openings(simulated_run: Path, truth: dict[str, Any]) -> None:
    import geopandas

    run = open_run(simulated_run)
    path = simulated_run / "products" / "geoparquet" / "opening_outlines.parquet"
    for frame in (geopandas.read_parquet(path), run.openings()):
        assert frame.crs == pyproj.CRS(Store(simulated_run).world().crs)
        for row in frame.to_dict("records"):
            check(row, ring(row["geometry"]), truth[row["id"]])
    facades = run.table("facades").set_index("id")
    for name, facade in ((name, run.plane(name)) for name in run.facades):
        glass = [shapely.Polygon(o["outline"]).area for o in truth.values() if o["id"].startswith(name)
                 and o["kind"] in ("window", "shopfront", "basement", "other")]  # fmt: skip
        ratio = sum(glass) / shapely.Polygon(facade.outline).area
        assert facades.loc[name, "window_to_wall"] == pytest.approx(ratio, rel=1e-9)
        assert 0 < facades.loc[name, "sigma_window_to_wall"] < 0.1 * ratio
        towards = np.deg2rad(facades.loc[name, "bearing"])
        assert [np.sin(towards), np.cos(towards)] == pytest.approx(-facade.frame.R[:2, 1], abs=1e-3)
    with pytest.raises(InputError, match="no layer 'doors'; there are buildings"):
        run.table("doors")


def test_csv_gives_back_the_openings(simulated_run: Path, truth: dict[str, Any]) -> None:
    with (simulated_run / "products" / "openings.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["id"] for row in rows} == truth.keys()
    for row in rows:
        check(row, ring(shapely.from_wkt(row["wkt"])), truth[row["id"]])


def test_schedule_shows_every_opening_with_its_picture(simulated_run: Path, truth: dict[str, Any]) -> None:
    book = openpyxl.load_workbook(simulated_run / "products" / "openings.xlsx")
    assert book.sheetnames == ["Openings", "Facades", "About"]
    sheet = book["Openings"]
    head, *rows = sheet.iter_rows(values_only=True)
    names = [str(h).split(" [")[0] for h in head]
    found = {row[names.index("id")]: dict(zip(names, row, strict=True)) for row in rows}
    assert found.keys() == truth.keys()
    for name, row in found.items():
        record = truth[name]
        z = np.array(record["outline_world"])[:, 2]
        assert (row["sill"], row["head"]) == pytest.approx((z.min(), z.max()), abs=TOLERANCE_M)
        assert row["width"] == pytest.approx(np.ptp(np.array(record["outline"])[:, 0]), abs=TOLERANCE_M)
        assert row["material"] == "unknown"
    pictures = {image.anchor._from.row: Image.open(io.BytesIO(image._data())) for image in sheet._images}
    assert sorted(pictures) == list(range(1, len(truth) + 1))
    wide = {row[names.index("id")]: k for k, row in enumerate(rows, 1)}
    for name, record in truth.items():
        width, height = np.ptp(np.array(record["outline"]), axis=0)
        w, h = pictures[wide[name]].size
        assert max(w, h) <= 160
        assert (w > h) == (width > height) or abs(width - height) < 0.1


def test_tables_of_a_run_without_photos_and_with_a_failed_facade(simulated_run: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    store = Store(out)
    manifest = json.loads(store.manifest_path.read_text())
    manifest["project"]["photos"] = None
    warning = {"item": "B01", "code": "F101", "message": "has no wall", "hint": ""}
    manifest["stages"]["facades"]["warnings"] = [warning]
    store.manifest_path.write_text(json.dumps(manifest))
    survey = gather_survey(store)
    assert survey.photos == ()
    assert survey.left_out == (
        "The run has no photos: their layer is empty.",
        "B01: has no wall [F101]",
    )
    assert products.untold(survey) == ("The run has no photos: their layer is empty.",)


def test_a_missing_extra_is_told_and_its_older_file_removed(
    simulated_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    before = {p.name: p.read_bytes() for p in (out / "products").glob("*.*")}

    def without(*_: Any) -> None:
        raise MissingExtra("writing a workbook", "products")

    monkeypatch.setattr("frontage.pipeline.stages.tables.write_workbook", without)
    told = run_stage(out, "tables").notes
    assert any("openings.xlsx left out" in note and "frontage[products]" in note for note in told)
    assert not (out / "products" / "openings.xlsx").exists()
    monkeypatch.undo()
    run_stage(out, "tables")
    after = {p.name: p.read_bytes() for p in (out / "products").glob("*.*")}
    assert after == before  # the same bytes every time


def test_elevations_lie_in_the_plane_of_their_facade(simulated_run: Path, truth: dict[str, Any]) -> None:
    path = simulated_run / "products" / "frontage.gpkg"
    zero = Store(simulated_run).facade("B01/F1").height_of_zero
    frame = pyogrio.read_dataframe(path, layer="opening_elevations", where="facade = 'B01/F1'")
    assert frame.crs is None or frame.crs.is_engineering
    for row in frame.to_dict("records"):
        record = truth[row["id"]]
        expected = np.array(record["outline"]) + np.array([0.0, zero])
        np.testing.assert_allclose(ring(row["geometry"])[:, :2], expected, atol=TOLERANCE_M, rtol=0)
    bars = open_run(simulated_run).table("bar_elevations")
    assert bars.crs is None
    for row in bars.to_dict("records"):
        record = truth[row["opening"]]
        known = {round(b["position"], 4): b for b in record["bars"][row["axis"]]}
        at = row["position"] - (zero if row["axis"] == "horizontal" else 0.0)
        assert round(at, 4) in known or round(at, 4) + 1e-4 in known
