"""Runs that lack something: every product says what it leaves out, in its own file where that has a place."""

import base64
import json
import re
import shutil
import sqlite3
import zipfile
import zlib
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ezdxf
import ifcopenshell
import openpyxl
import pytest

from frontage.model import Failed
from frontage.pipeline.project import load_project
from frontage.pipeline.run import run, run_stage
from frontage.pipeline.store.store import Store
from frontage.viewer import program
from frontage.viewer.export import export
from frontage.viewer.site import site_of

STAGES = "frontage.pipeline.stages"


@dataclass(frozen=True)
class Case:
    """Something that a run of two houses lacks.

    fails  (stage, function of it, id that it fails for); None = nothing fails, but photos are lacking
    words  what each product says; a product that is not named has nothing to say
    gone   files that must not be there
    moved  whether there were photos, which now are somewhere else
    """

    fails: tuple[str, str, str] | None
    words: dict[str, str]
    gone: tuple[str, ...] = ()
    moved: bool = False


FACADE, ORTHO = "B02: none here [X101]", "no picture, of: B02/F1"
OPENINGS = "not looked for on: B02/F1"
TABLES = ("gpkg", "xlsx", "qgz")
MODELS = ("city.json", "gml", "gml3", "lod3.glb", "tileset")
PLANES = ("facades.glb", "facades.obj")
CASES = {
    "photos": Case(
        None,
        {
            **dict.fromkeys(TABLES, "The run has no photos"),
            "manifest": "The run has no photos",
            "report": "The run has no photos",
            "viewer": "no oriented photos",
        },
    ),
    "moved": Case(
        None,
        {
            **dict.fromkeys((*TABLES, "manifest", "report"), "The photos could not be read and are left out"),
            "viewer": "The photos could not be read",
        },
        moved=True,
    ),
    "facade": Case(
        ("facades", "find_facades", "B02"),
        {
            **dict.fromkeys((*TABLES, *MODELS, *PLANES, "ifc", "viewer", "missing"), FACADE),
            "manifest": "Without a facade, and so without a drawing: B02",
            "report": "No facade.",
        },
        ("products/elevations/B02.dxf", "products/rasters/B02_F1.vrt", "products/tiles/B02_lod2.glb"),
    ),
    "ortho": Case(
        ("ortho", "make_ortho", "B02/F1"),
        {
            **dict.fromkeys((*TABLES, *MODELS, *PLANES, "viewer"), ORTHO),
            **dict.fromkeys(("dxf", "pdf"), "Left out: the ortho-image"),
            "missing": "B02/F1: none here [X101]",
            "manifest": "not in model/facades.* and products/rasters: B02/F1",
            "report": "No ortho-image.",
        },
        ("products/rasters/B02_F1.vrt", "model/textures/B02_F1.jpg"),
    ),
    "openings": Case(
        ("openings", "find_openings", "B02/F1"),
        {
            **dict.fromkeys((*TABLES, *MODELS, "ifc", "viewer"), OPENINGS),
            **dict.fromkeys(("dxf", "pdf"), "Left out: openings"),
            "missing": "B02/F1: none here [X101]",
            "manifest": OPENINGS,
            "report": "Openings were not found, or not looked for.",
        },
    ),
    "solid": Case(
        ("model", "assemble", "B02"),
        {
            **dict.fromkeys((*TABLES, *MODELS, "missing"), FACADE),
            "viewer": "Not in the model: B02/F1.",
            "manifest": "none here",
            "report": "Not in the model.",
        },
        ("products/tiles/B02_lod2.glb",),
    ),
}


def abstract(file: Path) -> str:
    with zipfile.ZipFile(file) as packed:
        return re.findall(r"<abstract>(.*)</abstract>", packed.read("frontage.qgs").decode())[0]


def described(file: Path, query: str) -> str:
    with closing(sqlite3.connect(file)) as database:
        return str(database.execute(query).fetchone()[0])


def about(file: Path) -> str:
    rows = openpyxl.load_workbook(file)["About"].iter_rows(values_only=True)
    return " ".join(str(value) for row in rows for value in row)


def of_layouts(file: Path) -> str:
    drawing = ezdxf.readfile(file)
    return " ".join(t.dxf.text for name in drawing.layout_names() for t in drawing.layout(name).query("TEXT"))


def of_pages(file: Path) -> str:
    streams = re.findall(rb"stream\r?\n(.*?)~>endstream", file.read_bytes(), re.S)
    pages = (base64.a85decode(re.sub(rb"\s", b"", stream)) for stream in streams)
    return " ".join(zlib.decompress(page).decode("latin1") for page in pages if page[:1] == b"x")


def extras(file: Path) -> str:
    data = file.read_bytes()
    table = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    return str(table["asset"]["extras"].get("left_out"))


def entry(file: Path, *keys: str) -> str:
    table: Any = json.loads(file.read_text())
    for key in keys:
        table = table.get(key, "")
    return str(table)


def whole(file: Path) -> str:
    return file.read_text()


SAYS: dict[str, tuple[str, Callable[[Path], str]]] = {
    "gpkg": ("products/frontage.gpkg", lambda f: described(
        f, "SELECT description FROM gpkg_contents WHERE table_name = 'buildings'")),
    "missing": ("products/frontage.gpkg", lambda f: described(
        f, "SELECT missing FROM buildings WHERE id = 'B02'")),
    "xlsx": ("products/openings.xlsx", about),
    "qgz": ("products/frontage.qgz", abstract),
    "ifc": ("products/frontage.ifc",
            lambda f: ifcopenshell.open(f).by_type("IfcProject")[0].Description or ""),
    "dxf": ("products/elevations/B02.dxf", of_layouts),
    "pdf": ("products/elevations/B02.pdf", of_pages),
    "city.json": ("model/lod3.city.json", lambda f: entry(f, "metadata", "title")),
    "gml": ("model/lod3.gml", lambda f: "".join(re.findall("<gml:description>(.*?)</", whole(f)))),
    "gml3": ("model/lod3_citygml3.gml", lambda f: "".join(re.findall("<gml:description>(.*?)</", whole(f)))),
    "lod3.glb": ("model/lod3.glb", extras),
    "facades.glb": ("model/facades.glb", extras),
    "facades.obj": ("model/facades.offset.json", lambda f: entry(f, "left_out")),
    "tileset": ("products/tiles/tileset.json", lambda f: entry(f, "asset", "extras", "left_out")),
    "manifest": ("manifest.json", whole),
    "report": ("report.html", whole),
    "viewer": ("site/run.json", lambda f: entry(f, "left_out")),
}  # fmt: skip
"""What each product says: its file in the run folder, and how its words are read."""


def lacking(case: Case, project: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the run folder `out`, a finished run, one that lacks something."""
    if case.fails is None:
        manifest = json.loads((out / "manifest.json").read_text())
        photos = manifest["project"]["photos"]
        manifest["project"]["photos"] = {**photos, "path": str(out / "gone/*.jpg")} if case.moved else None
        (out / "manifest.json").write_text(json.dumps(manifest))
        run_stage(out, "export")
        run_stage(out, "report")
        return
    stage, function, failing = case.fails
    real = getattr(__import__(f"{STAGES}.{stage}", fromlist=[function]), function)

    def fails(*words: Any, **named: Any) -> Any:
        of = {getattr(word, "id", None) for word in words}
        return Failed("X101", "none here") if failing in of else real(*words, **named)

    monkeypatch.setattr(f"{STAGES}.{stage}.{function}", fails)
    run_stage(out, stage)
    run(load_project(project), out)


@pytest.mark.parametrize("name", CASES)
def test_every_product_says_what_it_leaves_out(
    name: str, project: Path, pair_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, out = CASES[name], Path(shutil.copytree(pair_run, tmp_path / "run"))
    lacking(case, project, out, monkeypatch)
    monkeypatch.setattr(program, "_FOLDER", tmp_path / "program")
    (tmp_path / "program").mkdir()
    (tmp_path / "program" / "index.html").write_text("<!doctype html>")
    assert export(site_of(Store(out)), out / "site").failed == ()
    said = {product: read(out / file) for product, (file, read) in SAYS.items() if product in case.words}
    silent = {product: said[product] for product, words in case.words.items() if words not in said[product]}
    assert not silent
    assert not [file for file in case.gone if (out / file).exists()]


def test_a_whole_run_leaves_nothing_out(simulated_run: Path) -> None:
    for product in ("gml", "lod3.glb", "facades.glb", "facades.obj", "tileset", "ifc", "qgz"):
        file, read = SAYS[product]
        assert read(simulated_run / file) in ("", "None", "[]"), product
