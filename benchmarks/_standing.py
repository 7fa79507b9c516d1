"""What stands before simulated facades, found against what was built."""

from dataclasses import dataclass, field

import numpy as np

from _mosaics import LOOSE, Street
from frontage.model import Facade, Occluder
from frontage.simulate.scene import Part

NAMES = {Part.TREE: "tree", Part.CAR: "car", Part.LAMP: "lamp", Part.PERSON: "person"}
STREET_M, BESIDE_M = 12.0, 1.0  # before and beside a facade: what `occluders.json` promises to list
NEAR_M = 1.0  # between the middles of a thing and of its box


@dataclass
class StandingScore:
    """Things built, found, found with their class; boxes without a thing; errors (m) of sides of boxes."""

    built: int = 0
    found: int = 0
    named: int = 0
    false: int = 0
    errors: list[float] = field(default_factory=list)

    def add(self, street: Street, facade: Facade, occluders: tuple[Occluder, ...]) -> None:
        """Compare the occluders of a facade with what stands before it."""
        left = list(occluders)
        for name, low, high in built(street, facade):
            self.built += 1
            middle = 0.5 * (low + high)
            near = [o for o in left if np.linalg.norm((o.centre - middle)[:2]) < NEAR_M]
            if not near:
                continue
            best = min(near, key=lambda o: float(np.linalg.norm((o.centre - middle)[:2])))
            left.remove(best)
            self.found += 1
            self.named += best.kind == name
            box = best.corners
            self.errors += [*np.abs(box.min(0) - low)[:2], *np.abs(box.max(0) - high)]
        self.false += len(left)

    def __str__(self) -> str:
        """One line of figures."""
        error = 100 * float(np.median(self.errors)) if self.errors else float("nan")
        return (
            f"{self.found} of {self.built} found, {self.named} with their class, "
            f"{self.false} boxes of nothing, sides of boxes off by {error:.0f} cm (median)"
        )


def built(street: Street, facade: Facade) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Class and extent (low, high) (3,) m in the facade frame of everything that stands before a facade."""
    scene, (x0, _), (x1, _) = street.scene, facade.outline.min(0), facade.outline.max(0)
    owner = [s.id.split("/")[0] for s in scene.surfaces]
    out = []
    for part in LOOSE:
        for name in sorted({owner[k] for k in np.flatnonzero(scene.parts == part)}):
            mine = [k for k in np.flatnonzero(scene.parts == part) if owner[k] == name]
            corners = scene.mesh.corners[np.isin(scene.mesh.surface, mine)].ravel()
            xyz = facade.frame.inverse.apply(scene.mesh.vertices[corners])
            low, high = xyz.min(0), xyz.max(0)
            if high[0] > x0 - BESIDE_M and low[0] < x1 + BESIDE_M and -STREET_M < high[1] < 0.0:
                out.append((NAMES[part], low, high))
    return out
