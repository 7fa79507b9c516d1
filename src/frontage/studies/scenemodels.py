"""A simulated scene's city models: the LoD2 of a surveying office, and the true LoD3."""

from pathlib import Path
from typing import Any

import numpy as np

from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.model import Surface
from frontage.model.citymodel import CityBuilding, Shell
from frontage.simulate.scene import House, OpeningPlan, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.survey import survey_model
from frontage.simulate.truth.solids import GRID, truth_solid


def write_lod2(out: Path, scene: Scene, spec: SceneSpec) -> dict[str, Any]:
    """lod2.city.json and lod2.gml with the errors that the spec asks for; what the truth says of them."""
    model = survey_model(scene, spec.model)
    buildings = []
    for b in model.buildings:
        heights = np.concatenate([s.ring[:, 2] for s in b.surfaces])
        about = {"measuredHeight": round(float(np.ptp(heights)), 2)}
        buildings.append(CityBuilding(b.id, (Shell("2.2", b.surfaces),), b.address, about))
    write_cityjson(out / "lod2.city.json", buildings, scene.world, f"{scene.name}, LoD2")
    write_citygml(out / "lod2.gml", buildings, scene.world, f"{scene.name}, LoD2")
    return {"shift": [round(float(v), 6) for v in model.shift]}


def write_lod3(path: Path, scene: Scene) -> None:
    """The true solids as CityJSON, windows and doors with depth and bars as in a run's lod3.city.json."""
    buildings = [_lod3(house, scene) for house in scene.houses]
    write_cityjson(path, buildings, scene.world, f"{scene.name}, true LoD3")


def _lod3(house: House, scene: Scene) -> CityBuilding:
    solid = truth_solid(house, scene.world)
    xyz = solid.vertices / GRID
    openings = {o.id: o for facade in house.facades for o in facade.openings}
    surfaces = tuple(
        Surface(
            xyz[list(face.ring)],
            face.semantics,
            face.opening or f"{house.id}_{number}",
            tuple(xyz[list(hole)] for hole in face.holes),
        )
        for number, face in enumerate(solid.faces)
    )
    about = {name: _about(opening) for name, opening in openings.items()}
    return CityBuilding(house.id, (Shell("3", surfaces, about),), house.address)


def _about(opening: OpeningPlan) -> dict[str, Any]:
    bars = [sum(b.axis == axis for b in opening.bars) for axis in ("vertical", "horizontal")]
    return {"depth": opening.depth, "n_vertical": bars[0], "n_horizontal": bars[1]}
