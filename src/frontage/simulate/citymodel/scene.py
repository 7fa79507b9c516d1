"""From a city model to a scene: the model's own buildings, what models lack drawn from the seed."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.errors import OptionError
from frontage.geometry.rigid import Rigid3
from frontage.model import CityModel
from frontage.simulate.citymodel.draft import ModelDraft, read_model_house
from frontage.simulate.citymodel.house import draw_model_house
from frontage.simulate.citymodel.site import Site, find_site, site_plan
from frontage.simulate.meshing import MeshBuilder, Pen
from frontage.simulate.scene import House, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.ground import StreetProfile, draw_ground
from frontage.simulate.street.obstacles import draw_obstacles

_AROUND = 40.0  # m of ground beyond the buildings
_DEEP = 0.5  # m that walls reach below the lowest ground
_SLOPE = 0.12


def build_model_scene(spec: SceneSpec, models: Sequence[CityModel]) -> Scene:
    """Build the scene of city models that share one world; the same spec and models give the same bytes.

    Every wall keeps its place and its openings. Windows that lie in their wall get a reveal, a frame and a
    pane; those that the model sets back keep their depth; every window gets a room. The street runs
    along the longest facades. What could not be used is said in the scene's notes.

    Raises OptionError when no building has a wall.
    """
    buildings = [b for m in models for b in m.buildings]
    found = [read_model_house(b, f"B{k + 1:02d}") for k, b in enumerate(buildings)]
    drafts = [d for d in found if d is not None and d.facades]
    if not drafts:
        raise OptionError(
            f"scene {spec.name!r}: no building of the model has a wall; give a model of LoD2 or LoD3"
        )
    site = find_site(drafts)
    profile, frame = _lie(drafts, site, np.random.default_rng((spec.seed, 0)))
    foot = _lowest(drafts, site, profile, float(frame.t[2]))
    builder = MeshBuilder()
    houses: list[House] = []
    for k, draft in enumerate(drafts):
        pen = Pen(builder, Rigid3("local", "local", np.eye(3), np.zeros(3)), draft.id, house=k)
        side = 0 if k in site.row else 1
        houses.append(draw_model_house(pen, draft, side, foot, np.random.default_rng((spec.seed, 8, k))))
    _draw_street(Pen(builder, frame), spec, profile, drafts, site)
    return Scene(
        name=spec.name,
        seed=spec.seed,
        world=models[0].world,
        local_from_street=frame,
        mesh=builder.mesh(),
        surfaces=tuple(builder.surfaces),
        materials=tuple(builder.materials),
        houses=tuple(houses),
        road=frame.apply(profile.centre_line(*site.span)),
        notes=tuple(_notes(models, buildings, found, site)),
    )


def _lie(drafts: Sequence[ModelDraft], site: Site, rng: np.random.Generator) -> tuple[StreetProfile, Rigid3]:
    """The street's section, and its frame at the height at which the houses on it stand."""
    frame = site.local_from_street
    s = np.array([site_plan(drafts[k], site).centroid.x for k in site.row])
    z = np.array([drafts[k].base for k in site.row])
    slope, start = 0.0, float(np.median(z))
    if len(s) > 2 and np.ptp(s) > 10:
        slope, start = (float(v) for v in np.polyfit(s, z, 1))
        slope = float(np.clip(slope, -_SLOPE, _SLOPE))
        start = float(np.mean(z - slope * s))
    pavement = min(float(rng.uniform(1.6, 3.0)), site.width / 4)
    lifted = Rigid3(frame.to, frame.frm, frame.R, np.array([*frame.t[:2], start]))
    return StreetProfile(site.width, pavement, slope), lifted


def _lowest(drafts: Sequence[ModelDraft], site: Site, profile: StreetProfile, start: float) -> float:
    """A height (m local) below the ground at every building."""
    s0, _, s1, _ = shapely.union_all([site_plan(d, site) for d in drafts]).bounds
    low = start + float(min(profile.slope * s0, profile.slope * s1))
    return min(low, *(d.base for d in drafts)) - _DEEP


def _draw_street(
    pen: Pen, spec: SceneSpec, profile: StreetProfile, drafts: Sequence[ModelDraft], site: Site
) -> None:
    """Ground around all buildings, and obstacles before those on the street."""
    plans = [site_plan(d, site) for d in drafts]
    s0, d0, s1, d1 = shapely.union_all(plans).bounds
    behind = max(d1, -profile.width - d0, 0.0) + _AROUND
    span = (s0 - _AROUND, s1 + _AROUND)
    draw_ground(pen, profile, span, plans, np.random.default_rng((spec.seed, 1)), behind)
    draw_obstacles(pen, profile, spec, *site.span, np.random.default_rng((spec.seed, 5)))


def _notes(
    models: Sequence[CityModel], buildings: Sequence[object], found: Sequence[ModelDraft | None], site: Site
) -> list[str]:
    """What of the models could not be used, one sentence each."""
    notes = [n for m in models for n in m.notes] + [f.message for m in models for f in m.problems]
    none = sum(d is None or not d.facades for d in found)
    if none:
        notes.append(f"{none} of {len(buildings)} buildings have no walls and were left out")
    for draft in found:
        if draft is not None and draft.lost:
            notes.append(
                f"{draft.id}: {draft.lost} windows or doors lie in no wall and are no openings of a facade"
            )
    if not any(f.openings for d in found if d is not None for f in d.facades):
        notes.append("the model has no windows and doors; the facades are blank")
    if not site.free:
        notes.append("no free street before any facade; it is laid through what is built")
    return notes
