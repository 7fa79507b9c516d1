"""IndoorGML: cells among each other and with their graph. Codes 701 to 704."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from frontage.model import Finding
from frontage.model.shape import CellGraph
from frontage.validation.composites import Body, adjacent, check_parts
from frontage.validation.geometry.distances import to_triangles, winding
from frontage.validation.tolerances import Tolerances


def check_rooms(
    graph: CellGraph, bodies: Sequence[Body], owners: Sequence[str], tolerances: Tolerances
) -> list[Finding]:
    """Findings on valid cells (`owners`: the cell of every body) and the graph that goes with them."""
    overlaps = [
        replace(f, code=701, message=f.message.replace("solids of one building", "cells"))
        for f in check_parts(bodies, owners, tolerances)
    ]
    by_cell = dict(zip(owners, bodies, strict=True))
    links = _broken_links(graph)
    moved = _outside(graph, by_cell)
    apart = [] if links else _not_adjacent(graph, by_cell, tolerances)
    return overlaps + moved + links + apart


def _outside(graph: CellGraph, bodies: Mapping[str, Body]) -> list[Finding]:
    """702: the state of a cell that does not stand in it."""
    findings = []
    for cell, state in graph.state_of_cell.items():
        if state in graph.position and cell in bodies:
            mesh = bodies[cell].shells[0][0]
            corners = bodies[cell].skin.corners
            spot = np.array([graph.position[state]]) - mesh.origin
            away, _ = to_triangles(spot, corners)
            if abs(winding(spot, corners)[0]) < 0.5 and away[0] > mesh.noise:
                text = f"the cell's state {state} stands {away[0]:.4g} m outside of it"
                findings.append(Finding(702, text, cell, "", graph.position[state]))
    return findings


def _broken_links(graph: CellGraph) -> list[Finding]:
    """703: references between cells, states and transitions that lead nowhere or do not come back."""
    findings = []
    for cell, state in graph.state_of_cell.items():
        if state and graph.cell_of_state.get(state) != cell:
            text = f"refers to state {state}, which " + (
                f"refers to {graph.cell_of_state[state] or 'no cell'}"
                if state in graph.cell_of_state
                else "is not there"
            )
            findings.append(Finding(703, f"the cell {text}", cell))
    for state, cell in graph.cell_of_state.items():
        if cell and cell not in graph.state_of_cell:
            findings.append(Finding(703, f"the state refers to cell {cell}, which is not there", state))
    for transition, ends in graph.ends.items():
        lost = [end for end in ends if end not in graph.cell_of_state]
        if lost or len(ends) != 2:
            text = (
                f"connects {lost[0]}, which is not there" if lost else f"connects {len(ends)} states, not 2"
            )
            findings.append(Finding(703, f"the transition {text}", transition))
    return findings


def _not_adjacent(graph: CellGraph, bodies: Mapping[str, Body], tolerances: Tolerances) -> list[Finding]:
    """704: a transition between cells that share no piece of a face."""
    findings = []
    for transition, ends in graph.ends.items():
        pair = [bodies[c] for e in ends if (c := graph.cell_of_state[e]) in bodies]
        if len(pair) == 2 and not adjacent(pair[0], pair[1], tolerances):
            text = "the transition connects cells that share no piece of a face"
            at = pair[0].shells[0][0].place(pair[0].skin.corners.mean((0, 1)))
            findings.append(Finding(704, text, transition, "", at))
    return findings
