"""Reflection and transmission of window panes: Fresnel's equations, coatings, one to three sheets, dirt."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float

INDEX = 1.52  # refractive index of float glass, 0.5 to 1.6 um
_COATING = {532: 0.08, 905: 0.35, 1064: 0.5, 1550: 0.8}  # reflectance of a low-emissivity film by wavelength
_ABSORBED = {532: 0.01, 905: 0.035, 1064: 0.045, 1550: 0.03}  # share absorbed by 4 mm of float glass


@dataclass(frozen=True, eq=False)
class Panes:
    """Optical properties of p panes.

    sheets     (p,) number of glass sheets
    coating    (p,) reflectance of the low-emissivity film, 0 = none
    absorbed   (p,) share of the light that one sheet absorbs at normal incidence
    dirt       (p,) albedo of the dirt on the pane
    """

    sheets: Array
    coating: Float
    absorbed: Float
    dirt: Float

    def take(self, index: Array) -> "Panes":
        """Return the panes at `index`."""
        return Panes(self.sheets[index], self.coating[index], self.absorbed[index], self.dirt[index])


def fresnel(cosine: Float, index: float = INDEX) -> Float:
    """Return the reflectance (n,) of one air-glass surface for unpolarised light.

    `cosine` (n,) is that of the angle of incidence, 0..1. The result is the mean of the s and p reflectances
    of Fresnel's equations: 4.3 % at normal incidence and 1 at grazing incidence.
    """
    c = np.clip(cosine, 0.0, 1.0)
    inner = np.sqrt(1 - (1 - c * c) / index**2)
    s = (c - index * inner) / (c + index * inner)
    p = (inner - index * c) / (inner + index * c)
    return np.asarray((s * s + p * p) / 2)


def pane_optics(panes: Panes, cosine: Float) -> tuple[Float, Float]:
    """Return the reflected and the transmitted share (n,) of beams that meet panes (n,).

    `cosine` (n,) is that of the angle of incidence. All inner reflections add up incoherently: a stack of N
    sheets has 2N surfaces of reflectance r, hence R = 2N r / (1 + (2N - 1) r); the film and the absorption of
    the sheets are one more layer each (Stokes 1862).
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
    """Draw the optical properties of panes; `group` (p,) >= 0 is the number of the house of each.

    A house has single, double (mostly coated) or triple glazing, as windows are renewed house by house; a
    tenth of the panes has been exchanged since. The albedo of the dirt is log-uniform between 0.01 and 1 %
    and partly common to the house. `wavelength` is in nm.
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
