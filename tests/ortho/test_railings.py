"""Railings hide nothing: the scan saw the wall between their bars, which it does not behind a parapet."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import Scan
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.occluders import find_occluders
from frontage.ortho.standing.find import find_standing
from ortho_wall import grid

OUT = 1.0  # m, balconies before the wall
GROUND = -3.0


@pytest.fixture(scope="module")
def balconies():
    """A wall with a balcony behind a railing on the left and one behind a parapet on the right."""
    facade = wall.facade(8.0, 6.0, spacing=0.03)
    bars = np.concatenate([grid(float(x), -OUT, (0.1, 1.0), 0.02) for x in np.arange(-3.0, -1.0, 0.12)])
    rails = np.concatenate([grid((-3.0, -1.0), -OUT, z, 0.02) for z in (0.1, 1.0)])
    parapet = grid((1.0, 3.0), -OUT, (0.0, 1.0))
    floors = np.concatenate([grid(x, (-OUT, 0.0), 0.0) for x in ((-3.0, -1.0), (1.0, 3.0))])
    front = grid((-4.0, 4.0), 0.0, (-3.0, 3.0))
    hidden = (front[:, 0] > 1.0) & (front[:, 0] < 3.0) & (front[:, 2] > 0.0) & (front[:, 2] < 1.2)
    street = grid((-4.0, 4.0), (-8.0, 0.0), GROUND, 0.1)
    parts = {"rails": np.concatenate([bars, rails]), "parapet": parapet}
    xyz = np.concatenate([*parts.values(), floors, front[~hidden], street])
    scan = Scan("street", facade.frame.apply(xyz), facade.world)
    return facade, scan, parts


def test_a_parapet_hides_the_wall_and_a_railing_does_not(balconies):
    facade, scan, _ = balconies
    xyz = facade.frame.inverse.apply(scan.xyz)
    cloud = find_occluders(facade, xyz, find_standing(facade, scan), None, OrthoOptions())
    part = cloud.part[0]
    out = part[(part[:, 1] < -0.9) & (part[:, 2] > 0.2) & (part[:, 2] < 0.9)]
    assert (out[:, 0] > 0.9).sum() > 500, "the parapet"
    assert (out[:, 0] < -0.9).sum() < 20, "the railing"


def test_the_wall_behind_a_railing_is_painted(balconies):
    facade, scan, _ = balconies
    picture = wall.texture(8.0, 6.0)
    photos = [
        wall.photo(facade, wall.camera(1000, 800), (x, -8.0, -1.4), name=f"{x:g}.jpg") for x in (-2.0, 2.0)
    ]
    shots = {p.id: wall.render(p, facade, picture) for p in photos}
    ortho = make_ortho(facade, scan, photos, shots.__getitem__, options=OrthoOptions(margin=0.0))
    alpha = ortho.pixels[..., 3] > 0
    above = np.s_[150:290]  # rows behind railing and parapet, 0.1 to 1.5 m high
    assert alpha[above][:, 110:290].mean() > 0.99
    assert alpha[above][:, 510:690].mean() < 0.85
