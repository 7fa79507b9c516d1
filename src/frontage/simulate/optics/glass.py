"""Window panes by energy: Fresnel's equations, uncoated and coated, one to three sheets, dirt."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float

INDEX = 1.52  # refractive index of float glass, 0.5 to 1.6 um
_COATING = {532: 0.08, 905: 0.35, 1064: 0.5, 1550: 0.8}  # reflectance of a low-emissivity film by wavelength
_ABSORBED = {532: 0.01, 905: 0.035, 1064: 0.045, 1550: 0.03}  # share absorbed by 4 mm of float glass


@dataclass(frozen=True, eq=False)
class Panes:
    """Optics per pane (p,): sheets, reflectance of the film (0 = none), loss in a sheet, albedo of dirt."""

    sheets: Array
    coating: Float
    absorbed: Float
    dirt: Float

    def take(self, index: Array) -> "Panes":
        """The panes at `index`."""
        return Panes(self.sheets[index], self.coating[index], self.absorbed[index], self.dirt[index])


def fresnel(cosine: Float, index: float = INDEX) -> Float:
    """Reflectance of one air-glass surface for unpolarised light, cosine of incidence (n,) in 0..1.

    Mean of the s and p reflectances of Fresnel's equations; 4.3 % at normal incidence, 1 at grazing.
    """
    c = np.clip(cosine, 0.0, 1.0)
    inner = np.sqrt(1 - (1 - c * c) / index**2)
    s = (c - index * inner) / (c + index * inner)
    p = (inner - index * c) / (inner + index * c)
    return np.asarray((s * s + p * p) / 2)


def pane_optics(panes: Panes, cosine: Float) -> tuple[Float, Float]:
    """Reflected and transmitted share (n,) of a beam that meets panes (n,) at `cosine` of incidence.

    Incoherent sum over all inner reflections: a stack of N sheets has 2N surfaces of reflectance r, hence
    R = 2N r / (1 + (2N - 1) r); a film of reflectance c and the absorption of the sheets join it as one more
    layer each (Stokes 1862).
    """
    r = fresnel(cosine)
    surfaces = 2.0 * panes.sheets
    reflected = surfaces * r / (1 + (surfaces - 1) * r)
    passed = 1 - reflected
    inner = np.sqrt(1 - (1 - np.clip(cosine, 0, 1) ** 2) / INDEX**2)
    clear = (1 - panes.absorbed) ** (panes.sheets / inner)
    once = 1 - reflected * panes.coating
    return (
        reflected + passed**2 * panes.coating * clear / once,
        passed * (1 - panes.coating) * clear / once,
    )


def draw_panes(group: Array, wavelength: int, rng: np.random.Generator) -> Panes:
    """Optics of panes (p,), `group` (p,) >= 0 numbers the houses: windows are renewed house by house.

    Single, double (mostly coated) or triple glazing per house with a few panes exchanged since; dirt
    albedo 0.01 to 1 %, log-uniform, some of it common to the house.
    """
    houses = int(group.max(initial=0)) + 1
    own = rng.random(len(group)) < 0.1

    def per_house(drawn: Array, single: Array) -> Array:
        return np.asarray(np.where(own, single, drawn[group]))

    kinds = np.array([[1, 0], [2, 0], [2, 1], [3, 1]])
    share = [0.15, 0.15, 0.5, 0.2]
    kind = kinds[per_house(rng.choice(4, houses, p=share), rng.choice(4, len(group), p=share))]
    film = _COATING[wavelength] * rng.uniform(0.8, 1.4, houses)[group]
    dirt = 10 ** (rng.uniform(-3.8, -2.3, houses)[group] + rng.normal(0, 0.2, len(group)))
    absorbed = np.full(len(group), _ABSORBED[wavelength])
    return Panes(kind[:, 0], kind[:, 1] * np.minimum(film, 0.9), absorbed, np.minimum(dirt, 0.02))
