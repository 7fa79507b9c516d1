"""The LoD2 city model that a surveying office would have: block models with realistic errors."""

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model.building import Surface
from frontage.simulate.scene import House, Scene

PLANE_M = 0.0005  # faces whose corners lie further from a plane than this are split into triangles


class ModelSpec(BaseModel):
    """Standard deviations of the city model's errors: `[model]`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    shift: float = Field(default=0.10, ge=0, le=20, description="m per axis, common to all houses")
    building: float = Field(default=0.05, ge=0, le=5, description="m per axis in plan, of each house")
    corner: float = Field(default=0.03, ge=0, le=2, description="m per axis in plan, of each corner")
    height: float = Field(default=0.10, ge=0, le=5, description="m, common shift in height")
    roof: float = Field(default=0.15, ge=0, le=5, description="m, height of each house's eaves and ridge")


@dataclass(frozen=True, eq=False)
class SurveyedBuilding:
    """A house of the city model: the surfaces of a closed LoD2 shell, with outer rings (k, 3) m local."""

    id: str
    address: str
    surfaces: tuple[Surface, ...]

    @property
    def footprint(self) -> Float:
        """Outline (k, 2) m local, counter-clockwise as seen from above."""
        ground = next(s for s in self.surfaces if s.semantics == "GroundSurface")
        return np.asarray(ground.ring[::-1, :2])


@dataclass(frozen=True, eq=False)
class SurveyedModel:
    """The houses of the city model, and the shift (3,) m that was added to all of them."""

    buildings: tuple[SurveyedBuilding, ...]
    shift: Float


def survey_model(scene: Scene, spec: ModelSpec, seed: int = 0) -> SurveyedModel:
    """Return block models of all houses of a scene, with the errors that `spec` asks for.

    As in official LoD2 models, walls are vertical and leaning, oriels and dormers are left out. Corners above
    one another move together, so that walls stay plane and shells stay closed.
    """
    rng = np.random.default_rng((scene.seed, seed, 0xC17))
    shift = rng.normal(0, 1, 3) * [spec.shift, spec.shift, spec.height]
    return SurveyedModel(tuple(_survey(h, shift, spec, rng) for h in scene.houses), shift)


def _survey(house: House, shift: Float, spec: ModelSpec, rng: np.random.Generator) -> SurveyedBuilding:
    own = np.array([*rng.normal(0, spec.building, 2), 0.0]) + shift
    corner = rng.normal(0, spec.corner, (4, 2))
    roof = float(rng.normal(0, spec.roof))
    leaning, upright = _frames(house)
    corners = leaning.inverse.apply(np.concatenate([ring for _, ring in house.shell]))
    low, size = corners.min(0), np.ptp(corners, axis=0)
    if len(house.footprint) != 4:  # oblique lines stay straight only under an affine transformation
        corner = _affine(corner)
    surfaces: list[Surface] = []
    for semantics, ring in house.shell:
        inside = leaning.inverse.apply(ring)
        xyz = upright.apply(inside)
        xyz[:, :2] += _bilinear(corner, *((inside - low) / size)[:, :2].T)
        xyz[:, 2] += np.where(inside[:, 2] > 0.01, roof, 0.0)
        for face in _plane_faces(xyz + own):
            surfaces.append(Surface(face, semantics, f"{house.id}_{len(surfaces)}"))
    return SurveyedBuilding(house.id, house.address, tuple(surfaces))


def _frames(house: House) -> tuple[Rigid3, Rigid3]:
    """Returns the frame of the house's front as it leans, and as it would be if it stood upright."""
    leaning = house.facades[0].local_from_facade
    x = leaning.R[:, 0]
    up = np.array([0.0, 0.0, 1.0])
    return leaning, Rigid3(leaning.to, leaning.frm, np.column_stack([x, np.cross(up, x), up]), leaning.t)


def _bilinear(corner: Float, u: Float, v: Float) -> Float:
    """Interpolates shifts (k, 2) at relative positions u, v between four corners (4, 2), front left first."""
    weight = np.column_stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    return weight @ corner


def _affine(corner: Float) -> Float:
    """Returns the shifts (4, 2) nearest to `corner` for which `_bilinear` is an affine map."""
    twist = np.array([1.0, -1.0, 1.0, -1.0])
    return np.asarray(corner - np.outer(twist, twist @ corner / 4))


def _plane_faces(ring: Float) -> list[Float]:
    """Returns the ring, or two triangles where the corners of a quadrilateral no longer lie in one plane."""
    if len(ring) != 4:
        return [ring]
    normal = np.cross(ring[2] - ring[0], ring[3] - ring[1])
    off = abs(float((ring[1] - ring[0]) @ normal)) / float(np.linalg.norm(normal))
    return [ring] if off < PLANE_M else [ring[[0, 1, 2]], ring[[0, 2, 3]]]
