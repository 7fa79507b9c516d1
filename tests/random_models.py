"""Random city models of ours, and what the official schemas and val3dity's rules say of their files.

A model is a house of a simulated street as it was planned, with elements left out, moved by some millimetres,
and added at random, with window bars, pictures, and the city model or none as its host.
"""

import json
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import cv2
import jsonschema
import numpy as np
from jsonschema import Draft7Validator
from lxml import etree

from frontage.exports import FacadePicture, city_buildings, painted
from frontage.geometry.arrays import Array, Float
from frontage.geometry.ring import rectangle
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.model import (
    Bar,
    Elements,
    Estimate,
    Facade,
    Glazing,
    Opening,
    OpeningKind,
    Protrusion,
    ProtrusionKind,
    Provenance,
    Surface,
    WorldRef,
)
from frontage.model.citymodel import CityBuilding, Shell
from frontage.queries.validation import validate_file
from frontage.simulate.scene import House, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.solids import BuildOptions, assemble
from frontage.solids.curves import arch_ring, circle_ring
from planned_houses import building, elements, facade
from realdata import citygml_schema, data_path

_CRS = ("EPSG:25832", "EPSG:25832+7837", "EPSG:2154", "EPSG:3857")
KINDS = ("CityJSON 2.0", "CityGML 2.0", "CityGML 3.0")
HOUSES = 2
"""On a street."""

_JITTER_M = 0.004
_SURE = np.eye(1) * 1e-6
_KINDS, _THINGS = tuple(OpeningKind), tuple(ProtrusionKind)


@dataclass(frozen=True, eq=False)
class RandomModel:
    """A model: its buildings, their world, the number of elements to build and of those refused."""

    name: str
    buildings: tuple[CityBuilding, ...]
    world: WorldRef
    elements: int
    refused: int
    failed: str = ""

    @property
    def textures(self) -> int:
        """How many polygons show a picture."""
        return sum(len(s.textures) for b in self.buildings for s in b.shells)

    @property
    def levels(self) -> set[str]:
        """The levels of detail, "installation" and "frame" where there are any."""
        shells = [s for b in self.buildings for s in b.shells]
        hung = {"frame" if s.frame_of else "installation" for s in shells if s.installation}
        return {s.lod for s in shells} | hung


def random_models(seed: int) -> list[RandomModel]:
    """The models of a street's houses."""
    rng = np.random.default_rng(seed)
    bare = {"opposite": False, "trees": 0, "cars": 0, "people": 0, "lamps": 0}
    scene = build_street(
        SceneSpec.model_validate({"seed": seed, "houses": HOUSES, "crs": str(rng.choice(_CRS)), **bare})
    )
    return [_model(rng, scene, house) for house in scene.houses]


def _model(rng: np.random.Generator, scene: Scene, house: House) -> RandomModel:
    fronts = [(facade(f, scene.world), _changed(rng, elements(f), f.outline)) for f in house.facades]
    count = sum(len(e.openings) + len(e.protrusions) for _, e in fronts)
    shell = Shell("2", tuple(Surface(ring, kind) for kind, ring in house.shell))
    options = BuildOptions(bars=bool(rng.random() < 0.7), reseat=bool(rng.random() < 0.3))
    made = assemble(building(house), fronts, [shell] if rng.random() < 0.6 else [], scene.world, options)
    name = f"{scene.seed}/{house.id}"
    if not made:
        return RandomModel(name, (), scene.world, count, 0, str(made))
    pictures = [_picture(rng, f) for f, _ in fronts if rng.random() < 0.7]
    city = city_buildings(building(house), made, fronts, {})
    shown = tuple(painted(b, pictures, 2.0) for b in city)
    return RandomModel(name, shown, scene.world, count, len(made.failed))


def _changed(rng: np.random.Generator, found: Elements, outline: Float) -> Elements:
    kept = [o for o in found.openings if rng.random() < 0.85]
    openings = [replace(o, ring=_jittered(rng, o.ring), glazing=_glazing(rng, o.ring)) for o in kept]
    low, high = outline.min(0), outline.max(0)
    things = [p for p in found.protrusions if rng.random() < 0.85]
    for k in range(rng.integers(0, 5)):
        name = f"{found.facade}/R{k}"
        openings.append(_opening(rng, name, _ring(rng, low, high)))
    for k in range(rng.integers(0, 4)):
        front = Estimate(float(rng.uniform(-1.5, 0.4)), _SURE, 9.0)
        kind = _THINGS[rng.integers(len(_THINGS))]
        ring = rectangle(*_box(rng, low, high, 3.0))
        things.append(Protrusion(f"{found.facade}/Q{k}", kind, ring, 0.01, front, Provenance.MEASURED, 0.9))
    held = {p.id for p in things}
    return Elements(found.facade, tuple(o for o in openings if not o.on or o.on in held), tuple(things))


def _opening(rng: np.random.Generator, name: str, ring: Float) -> Opening:
    depth = None if rng.random() < 0.2 else Estimate(float(rng.uniform(0.0, 0.6)), _SURE, 9.0)
    kind = _KINDS[rng.integers(len(_KINDS))]
    return Opening(
        name, kind, ring, np.eye(2 * len(ring)) * 1e-5, depth, "odd", Provenance.INFERRED, 3.0,
        float(rng.random()), int(rng.integers(0, 4)), 1, glazing=_glazing(rng, ring),
    )  # fmt: skip


def _box(
    rng: np.random.Generator, low: Float, high: Float, widest: float
) -> tuple[float, float, float, float]:
    """A box that may reach beyond the facade."""
    x, z = rng.uniform(low - 0.3, high - 0.5)
    return float(x), float(z), float(x + rng.uniform(0.3, widest)), float(z + rng.uniform(0.3, 2.0))


def _ring(rng: np.random.Generator, low: Float, high: Float) -> Float:
    x0, z0, x1, z1 = _box(rng, low, high, 2.0)
    kind = rng.integers(4)
    if kind == 0:
        return arch_ring(x0, x1, z0, spring=(z0 + z1) / 2, rise=(x1 - x0) / 2 * 0.8, chord_error=0.004)
    if kind == 1:
        return circle_ring((x0 + x1) / 2, (z0 + z1) / 2, (x1 - x0) / 2, 0.005)
    return _jittered(rng, rectangle(x0, z0, x1, z1))


def _jittered(rng: np.random.Generator, ring: Float) -> Float:
    return ring + rng.normal(0, _JITTER_M, ring.shape) if rng.random() < 0.5 else ring


def _glazing(rng: np.random.Generator, ring: Float) -> Glazing | None:
    if rng.random() < 0.4:
        return None
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    ups = np.sort(rng.uniform(x0 + 0.1, x1 - 0.1, rng.integers(0, 3))) if x1 - x0 > 0.4 else []
    levels = np.sort(rng.uniform(z0 + 0.1, z1 - 0.1, rng.integers(0, 3))) if z1 - z0 > 0.4 else []
    bars = [Bar("vertical", float(x), (z0, z1), float(rng.uniform(0.02, 0.1)), 0.003) for x in ups]
    bars += [Bar("horizontal", float(z), (x0, x1), float(rng.uniform(0.02, 0.1)), 0.003) for z in levels]
    width = Estimate(float(rng.uniform(0.03, 0.09)), _SURE, 9.0)
    return Glazing(bool(rng.random() < 0.8), tuple(bars), width, confidence=0.8, sources=("scan",))


def _picture(rng: np.random.Generator, shown: Facade) -> FacadePicture:
    """A picture of all or a part of a facade."""
    x0, z0, x1, z1 = shown.extent
    x0, x1 = x0 + rng.uniform(-0.5, 0.3) * (x1 - x0) * 0.5, x1 + 0.2
    image: Array = rng.integers(0, 256, (24, 32, 3), dtype=np.uint8)
    gsd = (x1 - x0) / 32
    size = (32, max(1, round((z1 - z0) / gsd)))
    jpeg = bytes(cv2.imencode(".jpg", cv2.resize(image, size))[1])
    return FacadePicture(shown, jpeg, gsd, (x0, z1 + 0.1), size)


def faults(model: RandomModel, folder: Path, kinds: Sequence[str] = KINDS) -> list[str]:
    """What is wrong with the files of a model by the official schemas, val3dity's rules, and our reader.

    Skips the test that calls it where the schemas are absent.
    """
    if model.failed:
        return [f"{model.name}: {model.failed}"]
    told = [
        f"{kind}: {text}" for kind in kinds for text in _faults(kind, _written(kind, model, folder), model)
    ]
    return [f"{model.name} {text}" for text in told]


def _written(kind: str, model: RandomModel, folder: Path) -> Path:
    if kind == "CityJSON 2.0":
        return write_cityjson(folder / "m.city.json", model.buildings, model.world, model.name)
    return write_citygml(folder / "m.gml", model.buildings, model.world, model.name, kind[-3:])


def _faults(kind: str, path: Path, model: RandomModel) -> Iterator[str]:
    if kind == "CityJSON 2.0":
        yield from (
            f"schema: {e.json_path} {e.message[:200]}"
            for e in _cityjson().iter_errors(json.loads(path.read_text()))
        )
    else:
        schema = _citygml(kind[-3:])
        if not schema.validate(etree.parse(str(path))):
            yield f"schema: {schema.error_log.last_error}"
    found = validate_file(path)
    yield from (f"{f.code} {f.message} at {f.feature}" for f in found.findings)
    yield from _reread(path, model)


def _reread(path: Path, model: RandomModel) -> Iterator[str]:
    """What our reader finds otherwise than it was written."""
    read = read_city_model(path, model.world)
    yield from (f"read: {problem}" for problem in read.problems)
    for name, count in (("shells", _shells), ("pictures", _pictures)):
        one, other = count(model.buildings), count(read.buildings)
        if one != other:
            yield f"read: {other} {name}, wrote {one}"


def _shells(buildings: Sequence[CityBuilding]) -> int:
    return sum(len(b.shells) for b in buildings)


def _pictures(buildings: Sequence[CityBuilding]) -> int:
    return sum(len(s.textures) for b in buildings for s in b.shells)


@cache
def _cityjson() -> Any:
    schema = json.loads(data_path("schemas/cityjson/cityjson.min.schema.json").read_text())
    plain = Draft7Validator.VALIDATORS["oneOf"]
    quick = jsonschema.validators.extend(Draft7Validator, {"oneOf": partial(_one_of, plain)})
    return quick(schema)


def _one_of(plain: Any, validator: Any, branches: list[Any], instance: Any, schema: Any) -> Iterator[Any]:
    """Check "oneOf" without the branches that cannot hold because they state another `type`.

    CityJSON's schema has 34 kinds of objects with up to eight kinds of geometry each; trying them all takes
    most of the time.
    """
    kind = instance.get("type") if isinstance(instance, dict) else None
    able = [b for b in branches if kind is None or not (own := _types(b)) or kind in own]
    yield from plain(validator, able or branches, instance, schema)


def _types(branch: dict[str, Any]) -> set[str]:
    """The values of `type` that a branch allows; empty if it states none."""
    stated = branch.get("properties", {}).get("type", {})
    own = {stated["const"]} if "const" in stated else set(stated.get("enum", ()))
    return own.union(*(_types(part) for part in branch.get("allOf", ())))


@cache
def _citygml(version: str) -> etree.XMLSchema:
    with tempfile.TemporaryDirectory() as folder:
        return citygml_schema(Path(folder), version, ("building", "generics", "appearance"))
