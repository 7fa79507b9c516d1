"""City models with the pictures of facades: placed to the pixel, valid by the schemas, read back."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyogrio
import pytest
from lxml import etree

from facade_fakes import GSD, WORLD, jpeg, ortho
from frontage.exports import FacadePicture, city_building, painted
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.model import Building, Elements, Shell
from frontage.model.citymodel import CityBuilding
from frontage.solids import BuildOptions, assemble
from opening_fakes import opening
from realdata import citygml_schema, data_path
from solids.test_assemble import GROUND, protrusion, wall, window

KINDS = ["city.json", "gml2", "gml3"]
IMAGE = "appearance/B01_F1.jpg"


@pytest.fixture(scope="module")
def house() -> CityBuilding:
    """Two windows with frames, one on an oriel, a third that stands outside the picture, and a balcony."""
    elements = Elements(
        "B01/F1",
        (
            opening(),
            window("B01/F1/W1-2", (2.2, 0, 3.8, 1.5), 0.2),
            window("B01/F1/W1-3", (-5, 2, -4.4, 2.6)),
        ),
        (protrusion("oriel", (2, -1, 4, 2), -0.8), protrusion("balcony", (-3.5, -1.5, -1.5, -0.4), -1.0)),
    )
    building = Building("B01", np.arange(3), GROUND, "13 rue Soufflot")
    made = assemble(building, [(wall(), elements)], (), WORLD, BuildOptions(bars=True))
    assert made
    return painted(city_building(building, made, [(wall(), elements)]), [picture()], 2.0)


def picture() -> FacadePicture:
    """The ortho-image without its leftmost 1.2 m."""
    image = ortho()
    (left, top), (width, height) = image.corner, image.size
    part = replace(image, pixels=image.pixels[:, 60:], depth=image.depth[:, 60:], source=image.source[:, 60:],
                   gsd_effective=image.gsd_effective[:, 60:], corner=(left + 1.2, top))  # fmt: skip
    return FacadePicture(wall(), jpeg(part), GSD, (left + 1.2, top), (width - 60, height))


def written(folder: Path, kind: str, house: CityBuilding) -> Path:
    if kind == "city.json":
        return write_cityjson(folder / "lod3.city.json", [house], WORLD, "one house")
    version = "2.0" if kind == "gml2" else "3.0"
    return write_citygml(folder / "lod3.gml", [house], WORLD, "one house", version)


def test_pictures_lie_where_the_facade_shows_them(house: CityBuilding) -> None:
    shown, (left, top), (width, height) = picture(), picture().corner, picture().size
    names = dict[str, set[str]]()
    for shell in house.shells:
        for s in shell.surfaces:
            texture = shell.textures.get(s.source_id)
            if texture is None:
                continue
            names.setdefault(shell.lod, set()).add(s.semantics)
            assert texture.image == IMAGE and len(texture.rings) == 1 + len(s.holes)
            for ring, places in zip((s.ring, *s.holes), texture.rings, strict=True):
                x, y, z = shown.facade.frame.inverse.apply(ring).T
                assert places[:, 0] * width * GSD + left == pytest.approx(x, abs=1e-9)
                assert top - (1 - places[:, 1]) * height * GSD == pytest.approx(z, abs=1e-9)
                assert abs(y.mean()) < 2.0
    assert names == {"2": {"WallSurface"}, "3": {"WallSurface", "Window"}}
    fine = next(s for s in house.shells if s.lod == "3" and not s.installation)
    assert {"B01/F1/W1-1", "B01/F1/W1-2"} <= fine.textures.keys() and "B01/F1/W1-3" not in fine.textures
    sides = [s for s in fine.surfaces if s.semantics == "WallSurface" and s.source_id not in fine.textures]
    assert len(sides) >= 3  # the other walls of the house
    assert not any(s.textures for s in house.shells if s.installation)


def places_by_corners(shell: Shell) -> dict[tuple, np.ndarray]:
    """Positions in the picture by the corners (0.1 mm) of every painted ring, from its lowest corner on."""
    found = {}
    for s in shell.surfaces:
        texture = shell.textures.get(s.source_id)
        for ring, places in zip((s.ring, *s.holes), texture.rings if texture else (), strict=False):
            corners = [tuple(c) for c in np.rint(ring * 1e4).astype(int).tolist()]
            first = corners.index(min(corners))
            found[tuple(np.roll(corners, -first, axis=0).ravel())] = np.roll(places, -first, axis=0)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_pictures_are_read_back(tmp_path: Path, kind: str, house: CityBuilding) -> None:
    model = read_city_model(written(tmp_path, kind, house), WORLD)
    (read,) = model.buildings
    assert model.problems == ()
    for lod in ("2", "3"):
        one, other = (
            places_by_corners(next(s for s in b.shells if s.lod == lod and not s.installation))
            for b in (house, read)
        )
        assert one.keys() == other.keys() and len(one) >= 1
        for corners, places in one.items():
            np.testing.assert_allclose(other[corners], places, atol=1e-6)
    images = {t.image for s in read.shells for t in s.textures.values()}
    assert images == {IMAGE}


def test_cityjson_with_pictures_is_valid(tmp_path: Path, house: CityBuilding) -> None:
    import jsonschema

    model = json.loads(written(tmp_path, "city.json", house).read_text())
    schema = json.loads(data_path("schemas/cityjson/cityjson.min.schema.json").read_text())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        jsonschema.validate(model, schema)
        assert model["appearance"]["textures"][0]["image"] == IMAGE
        model["appearance"]["textures"][0]["wrapMode"] = "stretch"
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(model, schema)


@pytest.mark.parametrize(("kind", "version"), [("gml2", "2.0"), ("gml3", "3.0")])
def test_citygml_with_pictures_is_valid(tmp_path: Path, kind: str, version: str, house: CityBuilding) -> None:
    folder = data_path(f"schemas/citygml/citygml/{version}/building.xsd").parent
    folder = data_path(f"schemas/citygml/citygml/{version}/building.xsd").parent
    schema = citygml_schema(tmp_path, version, ("building", "generics", "appearance"))
    tree = etree.parse(str(written(tmp_path, kind, house)))
    assert schema.validate(tree), schema.error_log.last_error
    located = tree.getroot().get("{http://www.w3.org/2001/XMLSchema-instance}schemaLocation").split()
    for namespace, place in zip(located[::2], located[1::2], strict=True):
        official = folder / Path(place).name  # of the same name in the published tree
        assert etree.parse(str(official)).getroot().get("targetNamespace") == namespace
        assert namespace in tree.getroot().nsmap.values()
    rings = {e.get(f"{{{e.nsmap['gml']}}}id"): e for e in tree.iter("{*}LinearRing")}
    named = list(tree.iter("{*}textureCoordinates"))
    targets = [e.get("ring") for e in named] if kind == "gml2" else [e.text for e in tree.iter("{*}ring")]
    for numbers, target in zip(named, targets, strict=True):
        corners = rings[target[1:]].findtext("{*}posList").split()
        assert len(numbers.text.split()) * 3 == len(corners) * 2
    next(tree.iter("{*}wrapMode")).text = "stretch"
    assert not schema.validate(tree)


def test_gdal_reads_the_solids_of_citygml_2(tmp_path: Path, house: CityBuilding) -> None:
    path = written(tmp_path, "gml2", house)
    sql = "SELECT MIN(OGR_GEOM_WKT), MIN(gml_id) FROM Building"  # numbers, because polyhedra are not arrays
    _, _, _, ((wkt,), (name,)) = pyogrio.raw.read(path, sql=sql, read_geometry=False)
    assert name == "B01" and wkt.startswith("POLYHEDRALSURFACE Z (((")
    fine = next(s for s in house.shells if s.lod == "3" and not s.installation)
    assert wkt.count("((") == len(fine.surfaces)
