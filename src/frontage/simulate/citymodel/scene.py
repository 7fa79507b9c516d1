"""Builds a scene from a city model: the model's own buildings, with what models lack drawn from the seed."""

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

_AROUND_M = 40.0  # of ground beyond the buildings
_DEEP_M = 0.5  # by which walls reach below the lowest ground
_SLOPE_MAX = 0.12  # m per m, of the street


def build_model_scene(spec: SceneSpec, models: Sequence[CityModel]) -> Scene:
    """Build the scene of city models that share one world reference.

    The same specification and models give the same bytes. Every wall keeps its place and its openings.
    Windows that lie flush in their wall get a reveal, a frame and a pane, those that the model sets back keep
    their depth, and every window gets a room. The street runs along the longest facades. The scene's notes
    say what could not be used.

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
    profile, frame = _street_profile(drafts, site, np.random.default_rng((spec.seed, 0)))
    foot = _below_ground(drafts, site, profile, float(frame.t[2]))
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


def _street_profile(
    drafts: Sequence[ModelDraft], site: Site, rng: np.random.Generator
) -> tuple[StreetProfile, Rigid3]:
    """Returns the street's cross-section, and its frame at the height of the houses that stand on it."""
    frame = site.local_from_street
    s = np.array([site_plan(drafts[k], site).centroid.x for k in site.row])
    z = np.array([drafts[k].base for k in site.row])
    slope, start = 0.0, float(np.median(z))
    if len(s) > 2 and np.ptp(s) > 10:
        slope, start = (float(v) for v in np.polyfit(s, z, 1))
        slope = float(np.clip(slope, -_SLOPE_MAX, _SLOPE_MAX))
        start = float(np.mean(z - slope * s))
    pavement = min(float(rng.uniform(1.6, 3.0)), site.width / 4)
    lifted = Rigid3(frame.to, frame.frm, frame.R, np.array([*frame.t[:2], start]))
    return StreetProfile(site.width, pavement, slope), lifted


def _below_ground(drafts: Sequence[ModelDraft], site: Site, profile: StreetProfile, start: float) -> float:
    """Returns a height (m local) that lies below the ground at every building."""
    s0, _, s1, _ = shapely.union_all([site_plan(d, site) for d in drafts]).bounds
    low = start + float(min(profile.slope * s0, profile.slope * s1))
    return min(low, *(d.base for d in drafts)) - _DEEP_M


def _draw_street(
    pen: Pen, spec: SceneSpec, profile: StreetProfile, drafts: Sequence[ModelDraft], site: Site
) -> None:
    """Draws the ground around all buildings, and obstacles in front of those that stand on the street."""
    plans = [site_plan(d, site) for d in drafts]
    s0, d0, s1, d1 = shapely.union_all(plans).bounds
    behind = max(d1, -profile.width - d0, 0.0) + _AROUND_M
    span = (s0 - _AROUND_M, s1 + _AROUND_M)
    draw_ground(pen, profile, span, plans, np.random.default_rng((spec.seed, 1)), behind=behind)
    draw_obstacles(pen, profile, spec, site.span, np.random.default_rng((spec.seed, 5)))


def _notes(
    models: Sequence[CityModel], buildings: Sequence[object], found: Sequence[ModelDraft | None], site: Site
) -> list[str]:
    """Returns one sentence for everything in the models that could not be used."""
    notes = [n for m in models for n in m.notes] + [f.message for m in models for f in m.problems]
    none = sum(d is None or not d.facades for d in found)
    if none:
        notes.append(f"{none} of {len(buildings)} buildings have no walls and were left out")
    for draft in found:
        if draft is not None and draft.lost:
            notes.append(f"{draft.id}: {draft.lost} windows or doors lie in no wall and were left out")
    if not any(f.openings for d in found if d is not None for f in d.facades):
        notes.append("the model has no windows and doors; the facades are blank")
    if not site.free:
        notes.append("there is no room for a street in front of any facade; it was laid through buildings")
    return notes
