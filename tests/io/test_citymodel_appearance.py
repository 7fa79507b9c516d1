"""Textures of city models are kept as references, corner by corner."""

from pathlib import Path

import numpy as np
import pytest

from city_files import write
from frontage.io.citymodels.read import read_city_model
from frontage.model import Shell
from realdata import data_path
from shape_files import FACES, VERTICES, city, cityjson, lod2_solid, members, polygon

PLACES = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]]
IN_BUILDING = "<appearance><Appearance>{}</Appearance></appearance></bldg:Building>"
IN_MODEL = "<appearanceMember><Appearance>{}</Appearance></appearanceMember></CityModel>"


def check(shell: Shell, painted: str) -> None:
    """One wall has a picture, and every corner the place that the file gives it."""
    ((name, texture),) = shell.textures.items()
    assert (name, texture.image) == (painted, "walls/a.jpg")
    (wall,) = [s for s in shell.surfaces if s.source_id == painted]
    foot = wall.ring[:, 2] == wall.ring[:, 2].min()
    np.testing.assert_array_equal(texture.rings[0][:, 1] == 0.0, foot)
    assert len(texture.rings) == 1 and len(texture.rings[0]) == len(wall.ring) == 4
    left = np.abs(wall.ring - wall.ring[0]).max(1) == 0
    assert (texture.rings[0][left] == PLACES[0]).all()


def gml(where: str, flipped: bool = False) -> str:
    faces = [f[::-1] if flipped else f for f in FACES]
    texts = [polygon(f, f"P{k}").replace("<gml:LinearRing>", f"<gml:LinearRing gml:id='R{k}'>")
             for k, f in enumerate(faces)]  # fmt: skip
    rows = [PLACES[FACES[2].index(i)] for i in (*faces[2], faces[2][0])]
    numbers = " ".join(str(v) for row in rows for v in row)
    texture = (
        "<surfaceDataMember><ParameterizedTexture><imageURI>walls/a.jpg</imageURI><target uri='#P2'>"
        f"<TexCoordList><textureCoordinates ring='#R2'>{numbers}</textureCoordinates>"
        "<textureCoordinates ring='#R3'>0 x 1</textureCoordinates><textureCoordinates ring='#R4'>0 1 1 1"
        "</textureCoordinates></TexCoordList></target></ParameterizedTexture></surfaceDataMember>"
    )
    whole = city(lod2_solid(members(*texts)))
    end = where.rpartition("</")[2]
    return whole.replace(f"</{end}", where.format(texture))


@pytest.mark.parametrize("where", [IN_BUILDING, IN_MODEL])
def test_textures_of_citygml(tmp_path: Path, where: str) -> None:
    (b,) = read_city_model(write(tmp_path / "a.gml", gml(where))).buildings
    check(b.shells[0], "P2")


def test_textures_turn_with_their_polygons(tmp_path: Path) -> None:
    (b,) = read_city_model(write(tmp_path / "a.gml", gml(IN_MODEL, flipped=True))).buildings
    ((_, texture),) = b.shells[0].textures.items()
    (wall,) = [s for s in b.shells[0].surfaces if s.source_id == "P2"]
    expected = [PLACES[FACES[2].index(VERTICES.index(p.tolist()))] for p in wall.ring]
    np.testing.assert_array_equal(texture.rings[0], expected)


def test_textures_of_cityjson(tmp_path: Path) -> None:
    model = cityjson()
    values = [[[None]], [[None]], [[0, 0, 1, 2, 3]], [[None]], [[7, 0, 1, 2, 3]], [[0, 0, 1]]]
    model["CityObjects"]["B1"]["geometry"][0]["texture"] = {"summer": {"values": [values]}}
    image = {"type": "JPG", "image": "walls/a.jpg"}
    model["appearance"] = {"textures": [image], "vertices-texture": PLACES}
    found = read_city_model(write(tmp_path / "a.city.json", model))
    assert found.problems == () and len(found.buildings[0].shells[0].surfaces) == 6
    check(found.buildings[0].shells[0], "B1/2")


def test_textures_of_a_published_model() -> None:
    (b,) = read_city_model(data_path("citymodels/ingolstadt_lod3/4018150b.xml")).buildings
    painted = [(s, shell.textures.get(s.source_id)) for shell in b.shells for s in shell.surfaces]
    there = [(s, t) for s, t in painted if t is not None]
    assert len(there) == 930  # 985 rings of the file have places; the other polygons have plain colours
    for surface, texture in there:
        assert [len(r) for r in texture.rings] == [len(surface.ring), *(len(h) for h in surface.holes)]
        assert texture.image.startswith("textures/")
