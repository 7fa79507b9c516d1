"""The unit cube as text in every file format that the validator reads."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np

VERTICES = [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
GML = (
    'xmlns:gml="http://www.opengis.net/gml" xmlns:bldg="http://www.opengis.net/citygml/building/2.0" '
    'xmlns:xlink="http://www.w3.org/1999/xlink" xmlns="http://www.opengis.net/citygml/2.0"'
)


def polygon(face: list[int], name: str = "", numbers: str = "posList") -> str:
    ring = [VERTICES[i] for i in (*face, face[0])]
    rows = [" ".join(str(v) for v in p) for p in ring]
    text = f"<gml:posList>{' '.join(rows)}</gml:posList>"
    if numbers == "pos":
        text = "".join(f"<gml:pos>{row}</gml:pos>" for row in rows)
    if numbers == "coordinates":
        text = f"<gml:coordinates>{' '.join(row.replace(' ', ',') for row in rows)}</gml:coordinates>"
    label = f' gml:id="{name}"' if name else ""
    ring_text = f"<gml:LinearRing>{text}</gml:LinearRing>"
    return f"<gml:Polygon{label}><gml:exterior>{ring_text}</gml:exterior></gml:Polygon>"


def members(*inside: str) -> str:
    return "".join(f"<gml:surfaceMember>{text}</gml:surfaceMember>" for text in inside)


def lod2_surface(inside: str) -> str:
    return f"<bldg:lod2MultiSurface><gml:MultiSurface>{inside}</gml:MultiSurface></bldg:lod2MultiSurface>"


def lod2_solid(inside: str) -> str:
    shell = f"<gml:CompositeSurface>{inside}</gml:CompositeSurface>"
    return f"<bldg:lod2Solid><gml:Solid><gml:exterior>{shell}</gml:exterior></gml:Solid></bldg:lod2Solid>"


def city(inside: str, name: str = "B1") -> str:
    return (
        f"<CityModel {GML}><cityObjectMember><bldg:Building gml:id='{name}'>{inside}</bldg:Building>"
        "</cityObjectMember></CityModel>"
    )


def cityjson(version: str = "2.0", **more: Any) -> dict[str, Any]:
    geometry = {"type": "Solid", "lod": "2", "boundaries": [[[f] for f in FACES]]}
    return {
        "type": "CityJSON",
        "version": version,
        "transform": {"scale": [0.5, 0.5, 0.5], "translate": [10, 20, 30]},
        "CityObjects": {"B1": {"type": "Building", "geometry": [geometry]}},
        "vertices": (np.array(VERTICES) * 2).tolist(),
        **more,
    }


def off() -> str:
    rows = [f"OFF\n{len(VERTICES)} {len(FACES)} 0"]
    rows += [" ".join(map(str, v)) for v in VERTICES] + [f"4 {' '.join(map(str, f))}" for f in FACES]
    return "\n".join(rows)


def obj() -> str:
    rows = ["# a cube", "o house"] + [f"v {x} {y} {z}" for x, y, z in VERTICES]
    return "\n".join(rows + ["f " + " ".join(f"{i + 1}/1/1" for i in f) for f in FACES])


def poly() -> str:
    rows = ["# a cube", "8 3 0 0"] + [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(VERTICES)]
    rows += ["6 0"] + [f"1 0\n4 {' '.join(str(i + 1) for i in f)}" for f in FACES]
    return "\n".join([*rows, "0", "0"])


def sequence() -> str:
    head = cityjson(CityObjects={}, vertices=[])
    whole = cityjson()
    feature = {
        "type": "CityJSONFeature",
        "id": "B1",
        "CityObjects": whole["CityObjects"],
        "vertices": whole["vertices"],
    }
    return json.dumps(head) + "\n" + json.dumps(feature) + "\n"


def jsonfg() -> str:
    shell = [[[VERTICES[i] for i in (*f, f[0])]] for f in FACES]
    place = {"type": "Polyhedron", "coordinates": [shell]}
    return json.dumps({"type": "Feature", "id": "B1", "geometry": None, "place": place})


def gml(numbers: str = "posList") -> str:
    return city(lod2_solid(members(*(polygon(f, "", numbers) for f in FACES))))


GOOD: dict[str, Callable[[], str]] = {
    "cube.city.json": lambda: json.dumps(cityjson()),
    "cube11.json": lambda: json.dumps(cityjson("1.1")),
    "cube.city.jsonl": sequence,
    "cube.fg.json": jsonfg,
    "cube.gml": gml,
    "pos.gml": lambda: gml("pos"),
    "coordinates.xml": lambda: gml("coordinates"),
    "cube.off": off,
    "cube.obj": obj,
    "cube.poly": poly,
}
