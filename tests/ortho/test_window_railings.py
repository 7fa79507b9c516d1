"""Railings before windows stand nearer to the wall than those of balconies, and ledges stand there, too."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import Scan
from frontage.ortho import OrthoOptions
from frontage.ortho.occluders import find_occluders
from frontage.ortho.standing.find import find_standing
from ortho_wall import grid

GROUND = -3.0


@pytest.mark.parametrize("out", [0.32, 0.42, 1.0])
def test_a_railing_hides_nothing_however_near_it_stands_and_a_ledge_does(out):
    facade = wall.facade(8.0, 6.0, spacing=0.03)
    bars = np.concatenate([grid(float(x), -out, (0.1, 1.0), 0.02) for x in np.arange(-3.0, -1.0, 0.12)])
    rails = np.concatenate([grid((-3.0, -1.0), -out, z, 0.02) for z in (0.1, 1.0)])
    ledge = np.concatenate([grid((1.0, 3.0), -0.42, (0.5, 0.62)), grid((1.0, 3.0), (-0.42, 0.0), 0.5)])
    floor = grid((-3.0, -1.0), (-out, 0.0), 0.0)
    front = grid((-4.0, 4.0), 0.0, (-3.0, 3.0))
    street = grid((-4.0, 4.0), (-8.0, 0.0), GROUND, 0.1)
    xyz = np.concatenate([bars, rails, ledge, floor, front, street])
    scan = Scan("street", facade.frame.apply(xyz), facade.world)
    cloud = find_occluders(
        facade, facade.frame.inverse.apply(scan.xyz), find_standing(facade, scan), None, OrthoOptions()
    )
    x, y, z = cloud.part[0].T
    railing = (x < -0.9) & (y < -out + 0.05) & (z > 0.15) & (z < 0.95)
    assert railing.sum() < 20
    assert ((x > 0.9) & (y < -0.35) & (z > 0.45) & (z < 0.7)).sum() > 150, "the ledge"
