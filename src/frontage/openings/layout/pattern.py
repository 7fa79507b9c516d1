"""Openings that rows and columns of like openings tell, where the scan shows them badly or not at all.

Trees, ledges and sparse points make one opening of two, half an opening of one, or none. Where the others of
its row and column are well known, they predict it to a few centimetres. A predicted opening competes with
whatever was found at its place:

    log p / (1 - p)  +  nats that the place looks like its fellows  -  nats that what it leaves over is open,

where p is the share of such predictions that are right on this facade. Only openings with a border that is
known no better than a decimetre are given up for a predicted one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit, logit

from frontage.geometry.arrays import Bool, Float
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.layout.forms import BUILT, Forms, is_known, is_placed
from frontage.openings.layout.groups import LIKE, WIDTH
from frontage.openings.layout.inferred import (
    SAME,
    WITHIN,
    Node,
    OpeningGrid,
    cells_of,
    iou_of,
    is_near,
    near_ones,
    rate_of,
    worth_at,
)
from frontage.openings.layout.likeness import Likeness
from frontage.openings.layout.remainder import LEAST, Part, Wall, strips_of
from frontage.openings.layout.selection import PRICE
from frontage.openings.wall.evidence import Evidence

_SURE = float(np.log(9.0))  # log odds of an opening where none was found


@dataclass(frozen=True, eq=False)
class Proposal:
    """An opening that others tell.

    place       box m
    covariance  (5, 5) m2 of left, right, bottom, top and rise
    like        an opening of its form
    nats        (3, 3) nats that its parts look like openings of the form, not like wall
    log_odds    that it is right before its place is looked at
    """

    place: Box
    covariance: Float
    like: Outline
    nats: Float
    log_odds: float


@dataclass(frozen=True, eq=False)
class Revision:
    """A predicted opening.

    instead   numbers of the outlines that it stands for
    chance    probability that it is there
    evidence  nats of its cells for open
    """

    proposal: Proposal
    instead: tuple[int, ...]
    chance: float
    evidence: float


def revise(outlines: Sequence[Outline], evidence: Evidence, feet: Sequence[bool]) -> list[Revision]:
    """Returns the openings that rows, columns and forms of the `outlines` tell better than the beams.

    `feet` says which outlines have a hidden foot near the ground, where doors stand among windows. They stay.
    """
    forms = Forms(outlines)
    if not forms.groups:
        return []
    firm = [o.place for o, foot in zip(outlines, feet, strict=True) if foot or is_known(o).all()]
    places = [o.place for o in outlines]
    boxes, likeness, wall = np.array(places), Likeness(evidence, places), Wall(evidence, outlines)
    judged = []
    for one in _proposals(outlines, forms, evidence, likeness, firm):
        if is_near(one.place, firm):
            continue
        rivals = tuple(np.flatnonzero(near_ones(one.place, boxes)).tolist())
        odds = one.log_odds + _gain(one, [outlines[k] for k in rivals], wall)
        if odds > (0.0 if rivals else _SURE):
            judged.append((odds, Revision(one, rivals, float(expit(odds)), worth_at(one.place, evidence))))
    found: list[Revision] = []
    for _, revision in sorted(judged, key=lambda j: (-j[0], j[1].proposal.place)):
        if not is_near(revision.proposal.place, [f.proposal.place for f in found]):
            found.append(revision)
    return found


def _proposals(
    outlines: Sequence[Outline],
    forms: Forms,
    evidence: Evidence,
    likeness: Likeness,
    firm: Sequence[Box],
) -> Iterator[Proposal]:
    """Yields the openings on the facade that rows, columns and forms predict.

    Where nothing was found, openings that are the only ones of their form predict others in their column as
    well, and the foot of the wall may be hidden.
    """
    taken = [o.place for o in outlines]
    for one in _at_nodes(outlines, forms, likeness, firm):
        if _is_on(one.place, evidence, upper=not is_near(one.place, taken)):
            yield one
    for one in _in_part(outlines, forms, likeness):
        if _is_on(one.place, evidence):
            yield one
    for one in _at_nodes(outlines, forms, likeness, firm, alone=True):
        if not is_near(one.place, taken) and _is_on(one.place, evidence, upper=True):
            yield one


def _at_nodes(
    outlines: Sequence[Outline],
    forms: Forms,
    likeness: Likeness,
    firm: Sequence[Box],
    *,
    alone: bool = False,
) -> list[Proposal]:
    """Returns what the rows and columns of the forms predict where they cross.

    `alone`: openings that are the only ones of their form stand in columns as well.
    """
    groups = [tuple(k for k in form if is_placed(outlines[k])) for form in forms.groups]
    groups = [form for form in groups if len(form) > 1]
    if not groups:
        return []
    known = {k for form in groups for k in form}
    numbers = [k for k, outline in enumerate(outlines) if k in known or (alone and is_placed(outline))]
    members = [outlines[k] for k in numbers]
    grid = OpeningGrid(members, [tuple(numbers.index(k) for k in form) for form in groups])
    nodes = grid.nodes([n for n, m in enumerate(members) if not is_known(m).all()])
    fellows = [[members[k].place for k in grid.fellows(n)] for n in nodes]
    told = [(n, likeness.nats(n.place, f)) for n, f in zip(nodes, fellows, strict=True)]
    rates = _Rates(grid.left_out(), told, firm, outlines)
    return [Proposal(n.place, n.covariance, members[n.like], nats, rates.log_odds(n)) for n, nats in told]


def _in_part(outlines: Sequence[Outline], forms: Forms, likeness: Likeness) -> list[Proposal]:
    """Returns the openings known in part as the others of their form have them."""
    found = []
    for one in forms.completed():
        fellows = [k for k in forms.groups[one.form] if k != one.number]
        nats = likeness.nats(one.place, [outlines[k].place for k in fellows])
        found.append(Proposal(one.place, one.covariance, outlines[fellows[0]], nats, _log_odds(one.share)))
    return found


def _log_odds(share: float) -> float:
    """Returns the log odds of a share, which is never known to be nothing or all."""
    return float(logit(np.clip(share, LEAST, 1.0 - LEAST)))


class _Rates:
    """How often what rows and columns predict is right: in all, along a row, and along a column.

    Predictions in columns without an opening of their form are counted by themselves.
    """

    def __init__(
        self,
        right: Sequence[Node],
        told: Sequence[tuple[Node, Float]],
        firm: Sequence[Box],
        outlines: Sequence[Outline],
    ) -> None:
        self._right = [{(n.row, n.column): True for n in right if n.same == same} for same in (False, True)]
        sure, places = np.reshape(firm, (-1, 4)), np.array([o.place for o in outlines])
        for node, nats in told:
            other = sure[near_ones(node.place, sure)]
            wrong = nats.sum() < -_SURE or any(iou_of(node.place, tuple(f)) < SAME for f in other)
            beside = np.flatnonzero(near_ones(node.place, places)).tolist()
            if wrong or any(_is_unlike(node, outlines[k]) for k in beside):
                self._right[node.same][node.row, node.column] = False

    def log_odds(self, node: Node) -> float:
        """Returns the log odds that a prediction is right before its place is looked at."""
        own = self._right[node.same]
        rates = (rate_of(own, *at) for at in ((None, None), (node.row, None), (None, node.column)))
        return _log_odds(min(rates))


def _is_unlike(node: Node, outline: Outline) -> bool:
    """Returns whether an opening is known to have another width than a node predicts."""
    size = np.array([node.place[2] - node.place[0], outline.place[2] - outline.place[0]])
    error = [float(WIDTH @ v[:4, :4] @ WIDTH) for v in (node.covariance, outline.covariance)]
    known = bool(is_known(outline)[:2].all())
    return known and abs(size[0] - size[1]) > LIKE * np.sqrt(sum(error) + BUILT**2)


def _is_on(place: Box, evidence: Evidence, *, upper: bool = False) -> bool:
    """Returns whether a place lies on the facade. With `upper`, it is enough that its upper half does.

    Hedges and cars hide the foot of a wall, and its outline ends above them. The other openings of the row
    tell where the sills are.
    """
    cells = cells_of(place, evidence)
    if cells is None:
        return False
    inside = evidence.inside[cells]
    return bool(inside[len(inside) // 2 if upper else 0 :].mean() >= WITHIN)


def _gain(told: Proposal, rivals: Sequence[Outline], wall: Wall) -> float:
    """Returns the nats for a predicted opening against what was found at its place.

    What neither leaves out tells nothing. What only the rivals take for open must be wall or a shadow
    (`Wall.open_beyond`). Every border of a rival that is not where the prediction has it costs what a border
    costs: the rival if it is vague, the prediction if it is well known.
    """
    evidence = wall.evidence
    own = cells_of(told.place, evidence)
    assert own is not None
    places = [cells_of(rival.place, evidence) for rival in rivals]
    part = _around([own, *(cells for cells in places if cells is not None)])
    mine = _mask(own, part)
    theirs = np.zeros_like(mine)
    gain, sigma = 0.0, np.sqrt(np.diag(told.covariance)[:4])
    for rival, cells in zip(rivals, places, strict=True):
        one = _mask(cells, part)
        theirs |= one
        gain -= sum(wall.open_beyond(strip, one & mine, part) for strip in strips_of(one & ~mine, own, part))
        error, known = np.sqrt(np.diag(rival.covariance)[:4]), is_known(rival)
        off = np.abs(np.subtract(rival.place, told.place))[[0, 2, 1, 3]]
        other = np.where(known, np.hypot(error, BUILT), evidence.raster.cell)
        apart = off > LIKE * np.hypot(sigma, other)
        gain += PRICE / 4.0 * float((~known).sum() - (known & apart).sum())
    left = ~theirs[own[0].start - part[0].start :, own[1].start - part[1].start :]
    rows, columns = (np.array_split(np.arange(s.stop - s.start), len(told.nats)) for s in own)
    share = [[float(left[np.ix_(r, c)].mean()) for c in columns] for r in rows]
    return gain + float((np.array(share) * told.nats).sum())


def _around(places: Sequence[Part]) -> Part:
    """Returns the smallest part of the raster that holds all places."""
    rows, columns = (
        slice(min(s.start for s in k), max(s.stop for s in k)) for k in zip(*places, strict=True)
    )
    return rows, columns


def _mask(cells: Part | None, part: Part) -> Bool:
    """Returns the cells of a place as a mask of a part (h, w) of the raster; None stands for no cells."""
    mask = np.zeros([s.stop - s.start for s in part], np.bool_)
    if cells is not None:
        rows, columns = (slice(s.start - p.start, s.stop - p.start) for s, p in zip(cells, part, strict=True))
        mask[rows, columns] = True
    return mask


def settled(revision: Revision, measured: Outline) -> Outline:
    """Returns a predicted opening with those of its measured borders that are seen and agree with it.

    The others have no part in the error that measured borders share.
    """
    told = revision.proposal
    place, covariance = np.array(told.place)[[0, 2, 1, 3]], told.covariance.copy()
    own, borders = np.array(measured.place)[[0, 2, 1, 3]], list(measured.borders)
    for k, border in enumerate(measured.borders):
        agree = abs(own[k] - place[k]) < 3.0 * np.sqrt(covariance[k, k] + measured.covariance[k, k])
        if border.is_seen and agree:
            place[k] = own[k]
            covariance[k, :] = covariance[:, k] = 0.0
            covariance[k, k] = measured.covariance[k, k]
        else:
            borders[k] = replace(border, edge=replace(border.edge, doubt=0.0))
    x0, x1, z0, z1 = (float(v) for v in place)
    like = told.like
    return replace(
        measured,
        shape=like.shape,
        place=(x0, z0, x1, z1),
        rise=like.rise,
        covariance=covariance,
        borders=tuple(borders),
        depth=measured.depth or like.depth,
        pooled=True,
    )
