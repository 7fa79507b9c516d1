"""From a spec to a street: the one function that the instruments start from."""

import numpy as np

from frontage.geometry.ring import rectangle
from frontage.geometry.rigid import Rigid3
from frontage.model import WorldRef
from frontage.simulate.meshing import MeshBuilder, Pen
from frontage.simulate.scene import FacadePlan, House, Material, OpeningPlan, Part, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.windows import OpeningMaterials, draw_opening


def street(spec: SceneSpec) -> Scene:
    """Build the street that `spec` asks for; the same spec gives the same bytes."""
    rng = np.random.default_rng(spec.seed)
    slope = (spec.slope if spec.slope is not None else float(rng.uniform(1, 8))) / 100
    width = spec.street_width or float(rng.uniform(11, 18))
    heading = float(rng.uniform(0, 2 * np.pi))
    c, s = np.cos(heading), np.sin(heading)
    local_from_street = Rigid3("local", "street", np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), np.zeros(3))
    builder = MeshBuilder()
    houses: list[House] = []
    ends = [0.0, 0.0]
    for side in range(2 if spec.opposite else 1):
        for _ in range(spec.houses):
            w = float(rng.uniform(6, 12))
            houses.append(
                _house(builder, local_from_street, len(houses), side, ends[side], w, width, slope, rng)
            )
            ends[side] += w
    length = max(ends)
    _ground(builder, local_from_street, length, width, slope)
    road = local_from_street.apply(np.array([[t, -width / 2, slope * t] for t in (0.0, length)]))
    return Scene(
        spec.name,
        spec.seed,
        WorldRef(np.array(spec.origin), spec.crs),
        local_from_street,
        builder.mesh(),
        tuple(builder.surfaces),
        tuple(builder.materials),
        tuple(houses),
        road,
    )


def _house(builder, local_from_street, number, side, s0, w, width, slope, rng) -> House:  # type: ignore[no-untyped-def]
    eye = np.eye(3)
    if side == 0:
        frame = Rigid3("street", "facade", eye, np.array([s0, 0.0, slope * s0]))
    else:
        frame = Rigid3("street", "facade", np.diag([-1.0, -1.0, 1.0]), np.array([s0 + w, -width, slope * s0]))
    local = local_from_street @ frame
    pen = Pen(builder, local, f"B{number + 1:02d}", number, 0)
    floors, depth = int(rng.integers(2, 5)), 10.0
    eaves = 3.4 + 3.1 * (floors - 1)
    rgb = tuple(float(v) for v in rng.uniform(0.3, 0.8, 3))
    plaster = Material("plaster", "plaster", rgb, (0.3, 0.3, 0.3), 0.5, seed=number)
    white = Material("white paint", "paint", (0.8, 0.8, 0.8), (0.7, 0.7, 0.7), 0.7, 0.1)
    glass = Material("glass", "glass", (0.02, 0.02, 0.02), (0.02, 0.02, 0.02), 0.02, 1.0)
    wood = Material("oak", "wood", (0.25, 0.15, 0.08), (0.2, 0.1, 0.05), 0.4, 0.1)
    tiles = Material("tiles", "tiles", (0.4, 0.15, 0.1), (0.2, 0.1, 0.1), 0.3, size=(0.2, 0.3))
    room = Material("room", "plaster", (0.6, 0.6, 0.55), (0.5, 0.5, 0.5), 0.6)
    openings = []
    columns = int(w // 2.2)
    pitch = w / columns
    for floor in range(floors):
        for k in range(columns):
            x = pitch * (k + 0.5)
            z0 = 0.9 + (0.4 + 3.1 * floor if floor else 0.0)
            door = floor == 0 and k == 0
            ring = rectangle(x - 0.55, 0.1 if door else z0, x + 0.55, z0 + 1.5)
            letter = "D" if door else "W"
            openings.append(
                OpeningPlan(
                    f"B{number + 1:02d}/F1/{letter}{floor}-{k + 1}",
                    "door" if door else "window",
                    "rectangle",
                    ring,
                    0.0,
                    0.15,
                    0.19,
                    0.07,
                    glazed=not door,
                    floor=floor,
                    bay=k + 1,
                )
            )
    facade = pen.of(f"B{number + 1:02d}/F1")
    wall = facade.surface("wall", Part.WALL, plaster, roughness=0.002)
    facade.plate(wall, rectangle(0, -2.0, w, eaves), 0.0, [o.ring for o in openings])
    for i, o in enumerate(openings):
        own = pen.of(o.id, opening=i)
        draw_opening(own, o, OpeningMaterials(plaster, white, glass, wood, wood), 0.4)
        if o.glazed:
            (x0, z0), (x1, z1) = o.ring.min(0), o.ring.max(0)
            inside = own.surface("room", Part.ROOM, room)
            around = rectangle(x0 - 0.4, z0 - 0.6, x1 + 0.4, z1 + 0.4)
            own.plate(inside, around, 0.4, [o.ring], inward=True)
            own.strip(inside, around, 0.4, 4.5)
            own.plate(inside, around, 4.5)
    body = pen.surface("body", Part.WALL, plaster, u=(0.0, 1.0, 0.0))
    for ring in (
        [[w, 0, -2], [w, depth, -2], [w, depth, eaves], [w, 0, eaves]],
        [[0, depth, -2], [0, 0, -2], [0, 0, eaves], [0, depth, eaves]],
        [[w, depth, -2], [0, depth, -2], [0, depth, eaves], [w, depth, eaves]],
    ):
        pen.polygon(body, np.array(ring, float))
    roof = pen.surface("roof", Part.ROOF, tiles)
    ridge = eaves + 3.0
    for ring in (
        [[0, 0, eaves], [w, 0, eaves], [w, depth / 2, ridge], [0, depth / 2, ridge]],
        [[w, depth, eaves], [0, depth, eaves], [0, depth / 2, ridge], [w, depth / 2, ridge]],
        [[w, 0, eaves], [w, depth, eaves], [w, depth / 2, ridge]],
        [[0, depth, eaves], [0, 0, eaves], [0, depth / 2, ridge]],
    ):
        pen.polygon(roof, np.array(ring, float))
    plan = FacadePlan(f"B{number + 1:02d}/F1", local, rectangle(0, 0, w, eaves), tuple(openings), (), 0.002)
    corners = local.apply(np.array([[0, 0, 0], [w, 0, 0], [w, depth, 0], [0, depth, 0]], float))
    z = float(local.t[2])
    return House(
        f"B{number + 1:02d}",
        f"{number + 1} Long Street",
        side,
        corners[:, :2],
        z,
        z + eaves,
        z + ridge,
        (plan,),
    )


def _ground(builder, local_from_street, length, width, slope) -> None:  # type: ignore[no-untyped-def]
    pen = Pen(builder, local_from_street)
    asphalt = Material("asphalt", "asphalt", (0.06, 0.06, 0.065), (0.1, 0.1, 0.1), 0.2)
    ground = pen.surface("ground", Part.GROUND, asphalt, v=(0.0, 1.0, 0.0))
    a, b = -40.0, length + 40.0
    ring = [[a, -width - 30, slope * a], [b, -width - 30, slope * b], [b, 30, slope * b], [a, 30, slope * a]]
    pen.polygon(ground, np.array(ring))
