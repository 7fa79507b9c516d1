"""The materials of a house, drawn from colours and reflectances that real houses have."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.simulate.scene import SurfaceMaterial

Rgb = tuple[float, float, float]

# linear RGB reflectances, from which one is picked and varied
_PLASTER: tuple[Rgb, ...] = (
    (0.72, 0.66, 0.52), (0.78, 0.75, 0.68), (0.66, 0.53, 0.33), (0.55, 0.33, 0.24), (0.45, 0.52, 0.44),
    (0.50, 0.55, 0.60), (0.70, 0.50, 0.42), (0.60, 0.60, 0.58), (0.74, 0.62, 0.36),
)  # fmt: skip
_BRICK: tuple[Rgb, ...] = ((0.33, 0.12, 0.08), (0.42, 0.19, 0.12), (0.52, 0.38, 0.22), (0.26, 0.13, 0.11))
_STONE: tuple[Rgb, ...] = ((0.55, 0.49, 0.38), (0.46, 0.44, 0.40), (0.50, 0.36, 0.28), (0.62, 0.58, 0.50))
_FRAME: tuple[Rgb, ...] = ((0.80, 0.80, 0.78), (0.80, 0.80, 0.78), (0.16, 0.09, 0.05), (0.09, 0.14, 0.10))
_VARIED_FRAME: tuple[Rgb, ...] = (
    *_FRAME, (0.80, 0.80, 0.78), (0.66, 0.62, 0.50), (0.30, 0.16, 0.07), (0.05, 0.055, 0.06),
    (0.33, 0.34, 0.35), (0.10, 0.15, 0.28), (0.28, 0.05, 0.04),
)  # fmt: skip
_FABRIC: tuple[Rgb, ...] = (
    (0.70, 0.69, 0.66), (0.70, 0.69, 0.66), (0.60, 0.52, 0.38), (0.35, 0.10, 0.08), (0.14, 0.18, 0.28),
    (0.10, 0.09, 0.08), (0.30, 0.36, 0.28),
)  # fmt: skip
_LEAF: tuple[Rgb, ...] = ((0.10, 0.05, 0.02), (0.03, 0.09, 0.06), (0.05, 0.06, 0.14), (0.24, 0.03, 0.02))
_SHUTTER: tuple[Rgb, ...] = ((0.07, 0.17, 0.10), (0.16, 0.22, 0.28), (0.24, 0.13, 0.07), (0.62, 0.62, 0.58))
_TILES: tuple[Rgb, ...] = ((0.36, 0.13, 0.08), (0.24, 0.10, 0.08), (0.13, 0.13, 0.15), (0.30, 0.18, 0.12))


@dataclass(frozen=True)
class Palette:
    """The materials of one house."""

    wall: SurfaceMaterial
    ground_floor: SurfaceMaterial
    plinth: SurfaceMaterial
    trim: SurfaceMaterial
    reveal: SurfaceMaterial
    frame: SurfaceMaterial
    pane: SurfaceMaterial
    leaf: SurfaceMaterial
    shutter: SurfaceMaterial
    roof: SurfaceMaterial
    metal: SurfaceMaterial
    room: SurfaceMaterial
    floor: SurfaceMaterial
    curtain: SurfaceMaterial
    furniture: SurfaceMaterial


def draw_palette(rng: np.random.Generator, wall: str | None = None) -> Palette:
    """Draw the materials of a house; `wall` fixes the kind of its walls ("plaster", "brick", "ashlar")."""
    kind = str(rng.choice(["plaster", "brick", "ashlar"], p=[0.6, 0.25, 0.15]))
    body = wall_material(rng, wall or kind)
    stone = _stone(rng, "stone")
    trim = stone if rng.random() < 0.5 else _paint(rng, "trim", _pick(rng, _PLASTER), 0.0)
    rusticated = body.kind == "plaster" and rng.random() < 0.3
    return Palette(
        wall=body,
        ground_floor=_stone(rng, "ashlar") if rusticated else body,
        plinth=_stone(rng, "ashlar") if rng.random() < 0.5 else stone,
        trim=trim,
        reveal=trim if body.kind != "plaster" else body,
        frame=_paint(rng, "frame", _pick(rng, _FRAME), 0.1),
        pane=glass(rng),
        leaf=_wood(rng, "leaf", _pick(rng, _LEAF)),
        shutter=_wood(rng, "shutter", _pick(rng, _SHUTTER)),
        roof=_roof(rng),
        metal=SurfaceMaterial(
            "metal", "metal", (0.06, 0.06, 0.07), (0.10, 0.07, 0.05), 0.25, 0.25, seed=_seed(rng)
        ),
        room=SurfaceMaterial(
            "room", "plaster", _vary(rng, (0.62, 0.60, 0.55)), (0.5, 0.5, 0.5), 0.6, seed=_seed(rng)
        ),
        floor=_wood(rng, "floor", (0.30, 0.19, 0.10)),
        curtain=SurfaceMaterial(
            "curtain", "fabric", _vary(rng, (0.66, 0.64, 0.60)), (0.5, 0.5, 0.5), 0.5, seed=_seed(rng)
        ),
        furniture=_wood(rng, "furniture", (0.22, 0.13, 0.07)),
    )


def varied_palette(palette: Palette, seed: tuple[int, ...]) -> Palette:
    """Return a palette with frames and curtains of more colours, among them ones close to each other."""
    rng = np.random.default_rng((*seed, 0xC0))
    frame, fabric = _pick(rng, _VARIED_FRAME), _pick(rng, _FABRIC)
    curtain = SurfaceMaterial("curtain", "fabric", _vary(rng, fabric), (0.5, 0.5, 0.5), 0.5, seed=_seed(rng))
    return replace(palette, frame=_paint(rng, "frame", frame, 0.1), curtain=curtain)


def wall_material(rng: np.random.Generator, kind: str) -> SurfaceMaterial:
    """Draw the material of a wall of some kind: "plaster", "brick" or "ashlar"."""
    if kind == "brick":
        rgb, mortar = _vary(rng, _pick(rng, _BRICK)), _vary(rng, (0.48, 0.46, 0.42))
        length, height = float(rng.uniform(0.21, 0.26)), float(rng.uniform(0.062, 0.083))
        return SurfaceMaterial(
            "brick", "brick", rgb, mortar, _laser(rng, rgb), 0.0, (length, height), _seed(rng)
        )
    if kind == "ashlar":
        return _stone(rng, "ashlar")
    rgb = _vary(rng, _pick(rng, _PLASTER))
    return SurfaceMaterial(
        "plaster", "plaster", rgb, _scale(rgb, 0.72), _laser(rng, rgb), 0.0, seed=_seed(rng)
    )


def glass(rng: np.random.Generator) -> SurfaceMaterial:
    """Draw window glass; its `laser` reflectance is that of the dust on it."""
    dirt = float(rng.uniform(0.002, 0.03))
    return SurfaceMaterial(
        "glass", "glass", (0.02, 0.025, 0.02), (0.02, 0.02, 0.02), dirt, 1.0, seed=_seed(rng)
    )


def _stone(rng: np.random.Generator, kind: str) -> SurfaceMaterial:
    rgb = _vary(rng, _pick(rng, _STONE))
    size = (float(rng.uniform(0.5, 0.9)), float(rng.uniform(0.28, 0.42)))
    return SurfaceMaterial(kind, kind, rgb, _scale(rgb, 0.6), _laser(rng, rgb), 0.0, size, _seed(rng))


def _roof(rng: np.random.Generator) -> SurfaceMaterial:
    rgb = _vary(rng, _pick(rng, _TILES))
    return SurfaceMaterial(
        "tiles", "tiles", rgb, _scale(rgb, 0.5), _laser(rng, rgb), 0.0, (0.19, 0.30), _seed(rng)
    )


def _paint(rng: np.random.Generator, name: str, rgb: Rgb, gloss: float) -> SurfaceMaterial:
    rgb = _vary(rng, rgb)
    return SurfaceMaterial(name, "paint", rgb, _scale(rgb, 0.85), _laser(rng, rgb), gloss, seed=_seed(rng))


def _wood(rng: np.random.Generator, name: str, rgb: Rgb) -> SurfaceMaterial:
    rgb = _vary(rng, rgb)
    return SurfaceMaterial(
        name, "wood", rgb, _scale(rgb, 0.7), _laser(rng, rgb), 0.05, (0.12, 1.0), _seed(rng)
    )


def _pick(rng: np.random.Generator, choices: tuple[Rgb, ...]) -> Rgb:
    return choices[int(rng.integers(len(choices)))]


def _vary(rng: np.random.Generator, rgb: Rgb) -> Rgb:
    factor = rng.uniform(0.85, 1.12) * rng.uniform(0.95, 1.05, 3)
    r, g, b = (float(round(v, 4)) for v in np.clip(np.array(rgb) * factor, 0.01, 0.88))
    return r, g, b


def _scale(rgb: Rgb, factor: float) -> Rgb:
    return rgb[0] * factor, rgb[1] * factor, rgb[2] * factor


def _laser(rng: np.random.Generator, rgb: Rgb) -> float:
    """Draws the reflectance at the laser's wavelength; only half of it follows the colour."""
    return float(round(np.clip(0.5 * np.mean(rgb) + 0.5 * rng.uniform(0.15, 0.85), 0.05, 0.9), 4))


def _seed(rng: np.random.Generator) -> int:
    return int(rng.integers(2**31))
