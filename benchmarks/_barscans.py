"""Simulated scans of varied windows from the street, without photos; only beams near windows are traced.

    case = scanned(11, spacing=0.02, stations=1)

The scanner stands on the pavement across the street, so that sills and reveals hide a part of every window.
"""

import hashlib
from pathlib import Path

import numpy as np

from _barcases import Case, _front, _light
from _barscore import TrueLayout
from _windows import WindowSet, _as_measured, _chosen, _facade, _oriels, _street
from frontage.geometry.arrays import Float
from frontage.model import Elements, Scan
from frontage.simulate.scene import FacadePlan, OpeningPlan, Scene
from frontage.simulate.sensors.instrument import ScannerSpec, draw_instrument
from frontage.simulate.sensors.ranging import measure_beams
from frontage.simulate.sensors.target import Target
from frontage.simulate.sensors.terrestrial import polar

_AROUND_M = 0.6  # of wall around every window
_VERSION = 1


def scanned(
    seed: int, spacing: float, stations: int = 1, most: int = 9, cache: Path | None = None, **house: object
) -> Case:
    """A simulated house whose windows are known from a scan alone.

    spacing  m between points on the wall, at the middle of the front
    house    keys of the house besides `windows = "varied"`
    """
    asked = WindowSet(seed, views=0, most=most, house=(("windows", "varied"), *house.items()))
    scene = _street(seed, asked.house)
    plan = scene.houses[1].facades[0]
    chosen = _chosen(plan, most)
    rng = np.random.default_rng([seed, 0x5CA])
    xyz, origins, index = _points(scene, plan, chosen, (seed, spacing, stations), cache)
    scan = Scan("scan", xyz, scene.world, origins, index)
    facade = _facade(plan, scene, scan)
    elements = Elements(facade.id, tuple(_as_measured(o, asked, rng) for o in chosen), _oriels(chosen))
    truth = {
        o.id: TrueLayout(o.bars, o.glazing, _front(o), light=_light(o.ring, o.frame_width)) for o in chosen
    }
    name = f"house {seed} at {1000 * spacing:.0f} mm from {stations}"
    return Case(name, facade, elements, (), _no_pixels, scan, truth)


def _no_pixels(name: str) -> Float:
    raise KeyError(name)


def _points(
    scene: Scene, plan: FacadePlan, chosen: tuple[OpeningPlan, ...],
    asked: tuple[int, float, int], cache: Path | None,
) -> tuple[Float, Float, np.ndarray]:  # fmt: skip
    """The points (n, 3) m local that the beams near the windows return, the sensors, and whose they are."""
    seed, spacing, stations = asked
    key = hashlib.sha256(scene.mesh.vertices.tobytes() + repr((_VERSION, asked, len(chosen))).encode())
    file = None if cache is None else cache / f"scan{key.hexdigest()[:20]}.npz"
    if file is not None and file.exists():
        kept = np.load(file)
        return kept["xyz"], kept["origins"], kept["index"]
    spec = ScannerSpec(subrays=7, colour=False)
    rng = np.random.default_rng([seed, stations, 0xBEA])
    instrument = draw_instrument(spec, rng)
    target = Target(scene, instrument.wavelength)
    to_local = plan.local_from_facade
    found, eyes = [], []
    for k in range(stations):
        eye = _eye(plan, stations, k, rng)
        centre = to_local.apply(eye[None])[0]
        aims = to_local.rotate(_aims(chosen, eye, spacing))
        noise = instrument.sigma_angle * rng.normal(size=aims.shape)
        beams = aims + noise
        beams /= np.linalg.norm(beams, axis=1, keepdims=True)
        m = measure_beams(target, instrument, np.broadcast_to(centre, beams.shape), beams, (seed, k, 0x5C))
        first = m.number == 1
        found.append(centre + m.range[first, None] * aims[m.beam[first]])
        eyes.append(centre)
    xyz = np.concatenate(found)
    index = np.repeat(np.arange(stations), [len(one) for one in found]).astype(np.int32)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        np.savez(file, xyz=xyz, origins=np.array(eyes), index=index)
    return xyz, np.array(eyes), index


def _eye(plan: FacadePlan, stations: int, k: int, rng: np.random.Generator) -> Float:
    """Where the k-th scanner stands, in the facade frame: on the other side of the street."""
    (x0, _), (x1, _) = plan.outline.min(0), plan.outline.max(0)
    share = (k + 0.5) / stations if stations > 1 else float(rng.uniform(0.0, 1.0))
    reach = 0.6 * (x1 - x0)
    x = (x0 + x1) / 2 + reach * (2 * share - 1) + float(rng.normal(0, 0.5))
    return np.array([x, -float(rng.uniform(8.0, 13.0)), 1.75])


def _aims(chosen: tuple[OpeningPlan, ...], eye: Float, spacing: float) -> Float:
    """Directions (n, 3) of the beams of a polar raster that cross the wall near a window, facade frame."""
    rings = np.concatenate([np.column_stack([o.ring[:, 0], np.full(len(o.ring), o.wall_y), o.ring[:, 1]])
                            for o in chosen])  # fmt: skip
    step = spacing / float(np.linalg.norm(rings.mean(0) - eye))
    low, high = rings.min(0) - _AROUND_M, rings.max(0) + _AROUND_M
    away = -eye[1] + min(low[1], 0.0)
    azimuth = np.arctan2(away, np.array([high[0], low[0]]) - eye[0])
    elevation = np.arctan2(np.array([low[2], high[2]]) - eye[2], away)
    az, el = (g.ravel() for g in np.meshgrid(np.arange(*azimuth, step), np.arange(*elevation, step)))
    ways = polar(az, el)
    near = np.zeros(len(ways), bool)
    for o in chosen:
        at = eye + ways * ((o.wall_y - eye[1]) / ways[:, 1])[:, None]
        inside = (at[:, [0, 2]] > o.ring.min(0) - _AROUND_M) & (at[:, [0, 2]] < o.ring.max(0) + _AROUND_M)
        near |= inside.all(1)
    return ways[near]
