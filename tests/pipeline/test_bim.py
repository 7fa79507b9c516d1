"""The building information model of a run: valid, and its openings are those of `openings.json`."""

import json
import shutil
from pathlib import Path
from typing import Any

import ifcopenshell
import ifcopenshell.geom
import ifcopenshell.util.element
import ifcopenshell.util.placement
import ifcopenshell.validate
import numpy as np
import pytest
import shapely

from frontage.exports.bim import WALL_THICKNESS_M, bim_buildings
from frontage.exports.survey import Survey, SurveyedBuilding
from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.io.bim.ifc import PROPERTIES, write_ifc
from frontage.model import Elements, Estimate, Opening, Protrusion, Provenance, WorldRef
from frontage.pipeline.stage import Job
from frontage.pipeline.stages import bim as stage
from frontage.pipeline.store.store import Store
from fronts import scan_wall

TOLERANCE_M = 1e-4


@pytest.fixture(scope="module")
def model(simulated_run: Path) -> Any:
    return ifcopenshell.open(simulated_run / "products" / "frontage.ifc")


@pytest.fixture(scope="module")
def truth(simulated_run: Path) -> dict[str, dict[str, Any]]:
    files = (simulated_run / "facades").glob("*/openings.json")
    return {o["id"]: o for file in files for o in json.loads(file.read_text())}


def findings(model: Any, rules: bool) -> list[Any]:
    """What the schema of IFC says against a model, and its rules, which take their time."""
    log = ifcopenshell.validate.json_logger()
    ifcopenshell.validate.validate(model, log, express_rules=rules)
    return list(log.statements)


def front(element: Any) -> Float:
    """The outline (k, 3) of an element's body at its front, in the CRS."""
    (solid,) = element.Representation.Representations[0].Items
    placed = ifcopenshell.util.placement.get_local_placement(element.ObjectPlacement)
    inner = ifcopenshell.util.placement.get_axis2placement(solid.Position)
    points = np.array([p.Coordinates for p in solid.SweptArea.OuterCurve.Points])[:-1]
    local = np.column_stack([points, np.full(len(points), solid.Depth), np.ones(len(points))])
    (shift,) = element.file.by_type("IfcMapConversion")
    return (local @ (placed @ inner).T)[:, :3] + (shift.Eastings, shift.Northings, shift.OrthogonalHeight)


def test_the_model_gives_back_the_openings(model: Any, truth: dict[str, Any]) -> None:
    holes = {e.Name: e for e in model.by_type("IfcOpeningElement") if e.HasFillings}
    assert holes.keys() == truth.keys() and len(holes) > 3
    doors = ("door", "garage")
    for name, hole in holes.items():
        record = truth[name]
        np.testing.assert_allclose(front(hole), record["outline_world"], atol=TOLERANCE_M, rtol=0)
        (filling,) = (r.RelatedBuildingElement for r in hole.HasFillings)
        assert filling.is_a() == ("IfcDoor" if record["kind"] in doors else "IfcWindow")
        x, z = np.array(record["outline"]).T
        assert filling.OverallWidth == pytest.approx(np.ptp(x), abs=TOLERANCE_M)
        assert filling.OverallHeight == pytest.approx(np.ptp(z), abs=TOLERANCE_M)
        depth = np.linalg.norm(front(filling).mean(0) - front(hole).mean(0))
        assert depth == pytest.approx(max(record["depth"] or 0.0, 0.0), abs=TOLERANCE_M)
        about = ifcopenshell.util.element.get_psets(filling)[PROPERTIES]
        for side, sigma in record["sigma"].items():
            assert about.get(f"sigma_{side}") == pytest.approx(sigma, abs=TOLERANCE_M)
        for key in ("floor", "bay", "confidence", "provenance"):
            assert (
                about[key] == pytest.approx(record[key]) if key == "confidence" else about[key] == record[key]
            )


def test_the_model_is_valid_and_georeferenced(model: Any) -> None:
    assert model.schema_identifier == "IFC4X3_ADD2" and findings(model, rules=False) == []
    (crs,) = model.by_type("IfcProjectedCRS")
    assert crs.Name == "EPSG:25832"
    (wall, *_) = model.by_type("IfcWall")
    model_ids = [e.GlobalId for e in model.by_type("IfcRoot")]
    assert len(set(model_ids)) == len(model_ids)
    building = ifcopenshell.util.element.get_container(wall)
    assert building.is_a("IfcBuilding") and wall.Name.startswith(building.Name)


def volume(element: Any) -> float:
    shape = ifcopenshell.geom.create_shape(ifcopenshell.geom.settings(), element)
    faces = np.array(shape.geometry.faces).reshape(-1, 3)
    a, b, c = np.moveaxis(np.array(shape.geometry.verts).reshape(-1, 3)[faces], 1, 0)
    return float(np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6)


def opening(name: str, box: tuple[float, float, float, float], depth: float | None, on: str = "") -> Opening:
    found = None if depth is None else Estimate(depth, np.eye(1) * 1e-6, 10.0)
    return Opening(name, "window", rectangle(*box), np.eye(8) * 1e-6, found, "rectangle",
                   Provenance.MEASURED, 9.0, 0.99, 1, 1, on=on)  # fmt: skip


def thing(name: str, kind: str, box: tuple[float, float, float, float], front: float) -> Protrusion:
    estimate = Estimate(front, np.eye(1) * 1e-6, 10.0)
    return Protrusion(name, kind, rectangle(*box), 0.01, estimate, Provenance.MEASURED, 0.9)


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_walls_have_holes_and_things_stand_on_them(tmp_path: Path) -> None:
    facade, _ = scan_wall([])
    (x0, z0, _, _) = facade.extent
    box = lambda x, z, w, h: (x0 + x, z0 + z, x0 + x + w, z0 + z + h)  # noqa: E731
    elements = Elements(
        facade.id,
        (opening("W1-1", box(0.5, 0.5, 1.0, 1.2), 0.5),
         opening("W1-2", box(2.0, 0.6, 0.8, 1.0), None),
         opening("W1-3", box(3.2, 0.7, 0.5, 1.0), 0.1, "oriel"),
         opening("W1-4", box(4.3, 0.7, 0.5, 1.0), 0.1, "back")),
        (thing("oriel", "oriel", box(3.0, 0.5, 1.0, 1.6), -0.6),
         thing("back", "setback", box(4.2, 0.5, 0.8, 1.6), 0.2)),
    )  # fmt: skip
    building = SurveyedBuilding("B01", None, None, None, "", ((facade, elements),))
    survey = Survey(WorldRef(np.array([7, 8, 9]), None), (building,), (), np.empty((0, 3)), ())
    write_ifc(tmp_path / "a.ifc", bim_buildings(survey), survey.world, "a wall")
    model = ifcopenshell.open(tmp_path / "a.ifc")
    assert findings(model, rules=True) == [] and not model.by_type("IfcMapConversion")
    (site,) = model.by_type("IfcSite")
    at = ifcopenshell.util.placement.get_local_placement(site.ObjectPlacement)[:3, 3]
    np.testing.assert_array_equal(at, [7, 8, 9])
    walls = {w.Name: w for w in model.by_type("IfcWall")}
    (oriel,) = model.by_type("IfcBuildingElementProxy")
    about = ifcopenshell.util.element.get_psets(walls[facade.id])[PROPERTIES]
    thick = float(about["assumed"].split()[2])
    assert thick > max(WALL_THICKNESS_M, 0.5)
    area = shapely.Polygon(facade.outline).area
    expected = (area - 1.0 * 1.2 - 0.8 * 1.0 - 0.5 * 1.0) * thick - 0.8 * 1.6 * 0.2
    assert volume(walls[facade.id]) == pytest.approx(expected, abs=1e-4)
    assert volume(oriel) == pytest.approx((1.0 * 1.6 - 0.5 * 1.0) * 0.6, abs=1e-4)
    assert volume(walls["back"]) == pytest.approx((0.8 * 1.6 - 0.5 * 1.0) * thick, abs=1e-4)
    flush = next(w for w in model.by_type("IfcWindow") if w.Name == "W1-2")
    assert "depth is not known" in ifcopenshell.util.element.get_psets(flush)[PROPERTIES]["assumed"]


def test_models_are_the_same_every_time(simulated_run: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    store = Store(out)
    job = Job(store, store.project())
    stage.save(job, stage.work(job, stage.load(job)))
    path = Path("products") / "frontage.ifc"
    assert (out / path).read_bytes() == (simulated_run / path).read_bytes()
