"""Assumptions about buildings and measurements that several rooms share, each with its source."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Masonry:
    """Sizes of walls, doors and rooms, in m.

    half_brick     width of a brick of the normal format, 240 x 115 x 71 mm (DIN 105): no pier of masonry is
                   narrower, no leaf of masonry thinner
    panel          how far panels and blind niches lie behind the face of their wall at most: a quarter of a
                   brick (DIN 4172); leaves and panes lie deeper
    pier           width of a narrow pier between two openings or at the end of a wall (assumed)
    relief         how far plinths, cladding, sills and surrounds lie off the plane of their wall at most:
                   about the thickness of a wall of one and a half bricks, 0.365 m (assumed)
    step_out       a part of a wall that stands out or back by less is relief of that wall (assumed)
    threshold      two steps of a stair, 0.175 m each (DIN 18065 allows 0.20 m): a door that starts no higher
                   stands on the ground, and no wall need show below it
    door_height    headroom: doors are at least this high (door leaves of DIN 18101 begin at 1.985 m; old
                   houses have lower ones), and people walk under balconies and awnings that leave so much
    headroom       clear height under balconies, and under the wall over a gate or a glass front (assumed)
    person         height of a person: nothing lower is a room
    room_width     width of the front of the smallest room (assumed)
    room_height    height of that front: the clear height of 2.4 m that the German model building code
                   (section 47) asks for, and a floor
    largest_opening  no shop front or gate is wider or higher; a larger part behind the wall, as behind the
                   columns of a portico, is itself a wall (assumed)
    facade_reach   how far before its plane anything can stand that belongs to a facade, and how far behind it
                   the backs of niches lie (assumed)
    arcade         depth of an arcade: how far storeys jut out over the wall of their ground floor at most
                   (assumed)
    """

    half_brick: float = 0.115
    panel: float = 0.07
    pier: float = 0.5
    relief: float = 0.35
    step_out: float = 0.1
    threshold: float = 0.35
    door_height: float = 1.8
    headroom: float = 2.3
    person: float = 1.7
    room_width: float = 2.0
    room_height: float = 2.5
    largest_opening: float = 6.0
    facade_reach: float = 2.0
    arcade: float = 4.0

    def exceeds_opening(self, width: float, height: float) -> bool:
        """Return whether an open area (m) is larger than any opening and than the front of a room."""
        room = width >= self.room_width and height >= self.room_height
        return room and max(width, height) > self.largest_opening


@dataclass(frozen=True)
class ScanTolerances:
    """How far measurements may deviate from what they are taken for.

    parallel_deg   degrees between walls that still count as parallel: half of the 30 degrees by which the
                   sides of canted bays turn away from their fronts (assumed)
    least_on_wall  m: points this close to a wall are on it however quiet the scanner is: three times the 5 mm
                   (one sigma) by which plaster and courses of masonry are uneven (assumed)
    front_sigmas   standard deviations of a wall's points by which a front stands out or back at least
    bent_sigmas    standard deviations of its sagitta from which a wall counts as bent: more than three, for
                   the strips that tell it are few and their modes are not Gaussian
    common_noise   share of the noise of a point that its neighbours have in common (assumed)
    """

    parallel_deg: float = 15.0
    least_on_wall: float = 0.015
    front_sigmas: float = 5.0
    bent_sigmas: float = 5.0
    common_noise: float = 0.5

    @property
    def parallel_cos(self) -> float:
        """Cosine between the normals of walls that still count as parallel."""
        return float(np.cos(np.radians(self.parallel_deg)))


MASONRY = Masonry()
"""The assumptions that all rooms use."""

TOLERANCES = ScanTolerances()
"""The tolerances that all rooms use."""
