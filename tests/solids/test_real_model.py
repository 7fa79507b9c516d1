"""A real city model with true openings: every building gives a valid LoD3 solid."""

import json

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.io.citymodels.read import read_city_model
from frontage.model import Building, Elements, Estimate, Facade, Opening, Protrusion, Provenance
from frontage.solids import Assembled, BuildOptions, assemble
from frontage.solids.model_match import match_model
from frontage.validation import validate
from realdata import data_path


def scene() -> tuple[list[tuple[Facade, Elements]], object]:
    """Returns the true facades with what is on them, and the coarse model, which is 0.1 to 0.5 m off."""
    truth = json.loads(data_path("ingolstadt_scene/truth/truth.json").read_text())
    model = read_city_model(data_path("ingolstadt_scene/input/lod2/lod2.city.json"))
    fronts = []
    for f in truth["facades"]:
        planes = sorted({round(o["plane_offset"], 2) for o in f["openings"]})
        fronts += [_front(f, d, k == 0, model.world) for k, d in enumerate(planes or [0.0])]
    return fronts, model


def _front(f: dict, off: float, first: bool, world) -> tuple[Facade, Elements]:
    """Returns the openings `off` m in front of a facade's plane and, if `first`, the protrusions.

    In the scene u points right, v up and the normal outwards; in a facade frame y points inwards.
    """
    R = np.column_stack([f["e_u"], -np.array(f["normal"]), f["e_v"]])
    pose = Rigid3("local", "facade", R, world.to_local(np.array(f["origin"]) + off * np.array(f["normal"])))
    sure, none = np.eye(1) * 1e-6, np.zeros(0, np.int64)
    openings = []
    for o in f["openings"]:
        if round(o["plane_offset"], 2) != off:
            continue
        ring = np.array(o["polygon_uv"])
        deep = Estimate(float(o["depth"]), sure, 9.0)
        openings.append(
            Opening(
                f"{f['id']}/{o['id']}",
                o["kind"].lower(),
                ring,
                np.eye(2 * len(ring)) * 1e-6,
                deep,
                o["shape"],
                Provenance.MEASURED,
                9.0,
                1.0,
                0,
                0,
            )
        )
    hanging = tuple(
        Protrusion(f"{f['id']}/{p['id']}", "protrusion", rectangle(*p["uv"]), 0.01,
                   Estimate(-float(max(p["depth_range"])), sure, 9.0), Provenance.MEASURED, 1.0)
        for p in (f["protrusions"] if first else ())
    )  # fmt: skip
    outline = rectangle(0, 0, *f["size"])
    name = f"{f['id']}/{off}"
    facade = Facade(name, f["building"], Estimate(pose, np.eye(6) * 1e-8, 9.0), world, outline, (), none,
                    none, 0.0, 0.02, 1.0, "")  # fmt: skip
    return facade, Elements(name, tuple(openings), hanging)


@pytest.mark.parametrize("reseat", [False, True])
def test_true_openings_in_the_coarse_model(reseat: bool) -> None:
    fronts, model = scene()
    options = BuildOptions(reseat=reseat, max_offset=2.0)
    by_building: dict[str, list] = {}
    for facade, elements in fronts:
        by_building.setdefault(facade.building, []).append((facade, elements))
    groups = match_model({n: [f for f, _ in own] for n, own in by_building.items()}, model.buildings, options)
    found = cut = 0
    for group in groups:
        own = [front for name in group.measured for front in by_building[name]]
        shells = [s for b in model.buildings if b.id in group.model for s in b.level("2")]
        made = assemble(
            Building(group.measured[0], np.zeros(0, np.int64), np.nan), own, shells, model.world, options
        )
        assert isinstance(made, Assembled), made
        assert made.coarse.source == ("model" if group.model else "cloud")
        assert not any(validate(b.solid) for b in made.built), group
        assert not any(validate(i.solid) for i in made.installations), group
        assert not {"S320", "S399"} & {f.code for f in made.failed}
        found += sum(len(e.openings) for _, e in own)
        cut += len(
            {f.opening for b in made.built for f in b.solid.faces if f.semantics in ("Window", "Door")}
        )
    assert found > 100 and cut > 0.85 * found  # the others stand on walls that the coarse model lacks
