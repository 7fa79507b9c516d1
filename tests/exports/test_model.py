"""The LoD3 model as meshes and as a picture, and the walls that openings stand in."""

import cv2
import numpy as np
import pytest

from exports.test_facades import accessor, read_glb, world_of_vertices
from facade_fakes import GSD, WORLD, jpeg, ortho
from frontage.exports import FacadePicture, building_mesh, model_triangles, render_model
from frontage.exports.atlas import make_atlas
from frontage.exports.model3d import COLOURS
from frontage.exports.openingwalls import walls_of_openings
from frontage.exports.triangles import KINDS, ModelTriangles
from frontage.io.meshes.glb import GlbPiece, glb_of
from frontage.model import FRAME_THICKNESS_M, Elements
from frontage.solids import Assembled
from frontage.solids.brep import volume6
from opening_fakes import opening
from solids.test_assemble import house, protrusion, wall, window


def model(bars: bool = False) -> Assembled:
    elements = Elements(
        "B01/F1",
        (opening(), window("W2", (2.2, 0, 3.8, 1.5), 0.2), window("W3", (-1, -2, 0, -1), None)),
        (protrusion("oriel", (2, -1, 4, 2), -0.8), protrusion("balcony", (-3.5, -1.5, -1.5, -0.4), -1.0)),
    )
    return house(wall(), elements, bars=bars)


def test_triangles_enclose_the_volume_of_the_solids() -> None:
    made = model()
    a, b, c = np.moveaxis(model_triangles(made).corners, 1, 0)
    volume = np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6
    solids = [made.built[0].solid, *(i.solid for i in made.installations)]
    assert volume == pytest.approx(sum(volume6(s) for s in solids) / 6e12, rel=1e-5)


def test_the_ortho_image_lies_on_walls_and_panes_and_nothing_else() -> None:
    image = ortho()
    shown = FacadePicture(wall(), jpeg(image), GSD, image.corner, image.size)
    mesh = building_mesh(model(), [shown], 2.0)
    gltf, binary = read_glb(glb_of([mesh], WORLD))
    assert gltf["materials"][0]["name"] == "B01 pictures 1" and len(gltf["meshes"]) == 1
    xyz, uv = world_of_vertices(gltf, binary, 0)
    (place,) = make_atlas([jpeg(image)]).places
    uv = (uv - place.corner) / place.size
    local = WORLD.to_local(xyz)
    x, y, z = wall().frame.inverse.apply(local).T
    width, height = image.size
    assert uv[:, 0] * width == pytest.approx((x - image.corner[0]) / GSD, abs=0.01)
    assert uv[:, 1] * height == pytest.approx((image.corner[1] - z) / GSD, abs=0.01)
    assert sorted(set(np.round(y, 2).tolist())) == [-0.8, -0.6, 0.0, 0.12]
    plain = gltf["meshes"][0]["primitives"][1:]
    assert all("NORMAL" in p["attributes"] for p in plain)
    assert np.abs(accessor(gltf, binary, plain[0]["attributes"]["POSITION"])).max() < 12  # float32 is enough


def test_what_a_picture_does_not_reach_stays_plain() -> None:
    """A picture of the left half of the wall: nothing of it is drawn out over the other half."""
    image = ortho()
    w, h = image.size[0] // 2, image.size[1]
    half = cv2.imencode(".jpg", np.ascontiguousarray(image.pixels[:, :w, 2::-1]))[1].tobytes()
    shown = FacadePicture(wall(), half, GSD, image.corner, (w, h))
    pieces = building_mesh(model(), [shown], 2.0).pieces
    (place,) = make_atlas([half]).places
    uv = (pieces[0].uv - place.corner) / place.size
    assert uv.min() > -0.021 and uv.max() < 1.021
    whole = building_mesh(model(), [FacadePicture(wall(), jpeg(image), GSD, image.corner, image.size)], 2.0)
    assert sum(map(area, pieces)) == pytest.approx(sum(map(area, whole.pieces)), rel=1e-9)
    assert area(pieces[0]) == pytest.approx(0.5 * area(whole.pieces[0]), rel=0.1)


def area(piece: GlbPiece) -> float:
    a, b, c = np.moveaxis(piece.xyz[piece.faces], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_frames_have_the_colour_of_the_picture_and_panes_stand_behind_them() -> None:
    image = ortho()
    shown = FacadePicture(wall(), jpeg(image), GSD, image.corner, image.size)
    made = model(bars=True)
    pieces = {p.material.name: p for p in building_mesh(made, [shown], 2.0).pieces}
    assert {"Frame", "Pane"} <= set(pieces) and "Window" not in pieces
    assert pieces["Frame"].material.texture is None and pieces["Frame"].material.colour != COLOURS["Frame"]
    shapes = model_triangles(made)
    y = [wall().frame.inverse.apply(shapes.corners[shapes.kind == KINDS.index(k)].reshape(-1, 3))[:, 1]
         for k in ("Pane", "Frame")]  # fmt: skip
    assert sorted(set(np.round(y[0], 2).tolist())) == [-0.57, 0.15]
    assert y[1].min() == pytest.approx(-0.601, abs=1e-3) and y[1].max() == pytest.approx(0.184, abs=1e-3)


def test_fronts_of_frames_have_the_area_of_their_solids() -> None:
    made = model(bars=True)
    shapes = model_triangles(made)
    front = (shapes.kind == KINDS.index("Frame")) & (shapes.normals @ wall().frame.R[:, 1] < -0.99)
    a, b, c = np.moveaxis(shapes.corners[front], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    volume = sum(volume6(f.solid) for f in made.frames) / 6e12
    assert area * FRAME_THICKNESS_M == pytest.approx(volume, rel=3e-3)  # rounded to 0.1 mm


def test_the_picture_shows_frames() -> None:
    inward = wall().frame.R[:, 1]
    with_bars, without = (render_model(model_triangles(model(b)), inward, most=600) for b in (True, False))
    bright = [int((i.min(2) > 228).sum() - (i == 255).all(2).sum()) for i in (with_bars, without)]
    assert bright[0] > bright[1] + 50


def test_without_pictures_panes_are_glass_coloured() -> None:
    names = {p.material.name for p in building_mesh(model(), [], 2.0).pieces}
    assert {"WallSurface", "Window", "RoofSurface", "Installation"} <= names


def test_the_same_model_gives_the_same_bytes() -> None:
    assert glb_of([building_mesh(model(), [], 2.0)], WORLD) == glb_of(
        [building_mesh(model(), [], 2.0)], WORLD
    )


def test_the_picture_shows_the_street_side() -> None:
    inward = wall().frame.R[:, 1]
    front, back = (render_model(model_triangles(model()), v, most=300) for v in (inward, -inward))
    glass = [int(((i[..., 2].astype(int) - i[..., 0]) > 25).sum()) for i in (front, back)]
    assert glass[0] > 500 and glass[1] == 0
    assert (front[0] == 255).all() and front.shape[1] <= 300


def test_the_picture_is_taken_from_the_side_of_the_other_facades() -> None:
    inward = wall().frame.R[:, 1]
    aside = np.array([inward[1], -inward[0], 0.0])
    left = render_model(model_triangles(model()), inward, most=300)
    assert np.array_equal(
        render_model(model_triangles(model()), inward, np.array([inward, aside]), 300), left
    )
    assert not np.array_equal(
        render_model(model_triangles(model()), inward, np.array([inward, -aside]), 300), left
    )


def test_a_model_without_triangles_is_refused() -> None:
    none = np.zeros(0, np.int64)
    empty = ModelTriangles(
        np.zeros((0, 3, 3)), np.zeros((0, 3)), none, np.zeros((0, 2, 3)), none.astype("U1")
    )
    with pytest.raises(ValueError, match="nothing to draw"):
        render_model(empty, np.array([0.0, 1, 0]))


def test_openings_know_their_walls() -> None:
    solid = model().built[0].solid
    parents = {solid.faces[k].opening: solid.faces[w] for k, w in walls_of_openings(solid).items()}
    assert set(parents) == {"B01/F1/W1-1", "W2", "W3"}
    assert parents["W2"].opening == "B01/F1/oriel"
    assert parents["B01/F1/W1-1"] is parents["W3"] and len(parents["W3"].holes) == 3


def test_kinds_are_the_classes_of_faces() -> None:
    assert set(np.unique(model_triangles(model()).kind)) <= set(range(len(KINDS)))
