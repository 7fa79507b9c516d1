"""Beams without return: glass and dark rooms swallow beams, walls and shadows hardly do."""

from dataclasses import replace

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Float
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence, log_likelihood_ratio

_BEFORE = 0.3  # m before the wall that a station must stand
_FLAT = 1e-2  # cosine of the incidence of the flattest beam that is followed to the wall
_OPEN = 0.3  # share of the beams into an opening that are lost: panes and rooms return the others
_LEAST = 0.02  # share of the beams to a wall that are lost, at least
_WALLED = 0.7  # share of the expected beams that come back amid wall
_AROUND = 3.0  # m, side of the square of wall that shows how many beams the wall loses
_FEW = 10.0  # beams of that square: fewer tell nothing
_AMID = 3  # cells along and across that are looked at together
_MOST = 3.0  # nats of a cell from lost beams at most: neighbouring beams are lost together
_CAP = 6.0  # nats of a cell from all evidence at most


def lost_beam_places(facade: Facade, scan: Scan, beams: Beams) -> Float:
    """Returns the places (k, 2) x, z m where beams without return crossed the local wall of a facade.

    Anything that stops a beam sends it back, so the way to the wall was free.
    """
    x0, z0, x1, z1 = facade.extent
    x, z = np.meshgrid(np.linspace(x0, x1, 9), np.linspace(z0, z1, 9))
    box = facade.frame.apply(np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()]))
    found = [np.empty((0, 2))]
    for lost in scan.no_returns:
        eye = scan.origins[lost.origin]
        before = facade.frame.inverse.apply(eye[None])[0]
        if before[1] > -_BEFORE:
            continue
        ways = facade.frame.inverse.rotate(lost.towards(box - eye).directions)
        ways = ways[ways[:, 1] > _FLAT]
        slope = ways[:, [0, 2]] / ways[:, 1:2]
        foot = before[[0, 2]] - slope * before[1]
        place = foot + slope * beams.depth_at(*foot.T)[:, None]
        found.append(place[((place >= (x0, z0)) & (place <= (x1, z1))).all(1)])
    return np.vstack(found)


def with_lost_beams(evidence: Evidence, facade: Facade, scan: Scan, beams: Beams) -> Evidence:
    """Adds to the evidence the beams that structured scans are known to have lost.

    Each speaks for open by log(P(lost | open) / P(lost | wall)). The latter is what the wall around loses
    (dark, far or thinned-out walls lose many), and at least what the ground loses: what was cut out of the
    scan stood on the ground and leaves the same hole in the wall behind it. Where something before the wall
    stops other beams, its edges swallow beams as well. What the density has already told of missing beams is
    not counted twice.
    """
    lost = evidence.raster.count(*lost_beam_places(facade, scan, beams).T)
    if not lost.any():
        return evidence
    free = _free(evidence, beams, lost)
    share = np.maximum(_lost_by_wall(evidence, lost), max(n.ground for n in scan.no_returns))
    nats = free * np.minimum(np.log(np.maximum(_OPEN / share, 1.0)) * lost, _MOST)
    told = nats > 0.0
    if not told.any():
        return evidence
    missing = log_likelihood_ratio(evidence.expected, np.zeros(lost.shape), np.zeros(lost.shape))
    llr = np.clip(evidence.llr + np.maximum(nats - missing, 0.0), -_CAP, _CAP)
    return replace(
        evidence,
        llr=np.where(evidence.inside, llr, 0.0),
        expected=np.where(told & (evidence.expected <= 0.0), free * lost, evidence.expected),
        expected_free=np.where(told & (evidence.expected_free <= 0.0), lost, evidence.expected_free),
        seen=evidence.seen | told,
    )


def _lost_by_wall(evidence: Evidence, lost: Float) -> Float:
    """Returns the share (h, w) of its beams that the wall around loses."""
    solid, expected = (ndimage.uniform_filter(m, _AMID) for m in (evidence.solid, evidence.expected))
    wall = evidence.inside & (solid >= np.maximum(_WALLED * expected, 0.5 / _AMID**2))
    wide = max(int(_AROUND / evidence.raster.cell), 1)
    gone, came = (ndimage.uniform_filter(np.where(wall, m, 0.0), wide) for m in (lost, evidence.solid))
    few = _FEW / wide**2
    return np.asarray(np.maximum((gone + _LEAST * few) / (gone + came + few), _LEAST))


def _free(evidence: Evidence, beams: Beams, lost: Float) -> Float:
    """Returns the share (h, w) of the beams around that nothing before the wall stops."""
    stopped, others = (
        ndimage.uniform_filter(m, _AMID)
        for m in (evidence.raster.count(*beams.blocked.T), evidence.solid + evidence.open + lost)
    )
    return np.asarray(np.clip(1.0 - stopped / np.maximum(stopped + others, 1e-9), 0.0, 1.0))
