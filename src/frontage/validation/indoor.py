"""Level 7, IndoorGML: cells together, and with their graph. Codes 701 to 704."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from frontage.model import Finding
from frontage.model.shape import CellGraph
from frontage.validation.closed_surface import ValidSolid
from frontage.validation.composites import adjacent, check_parts
from frontage.validation.geometry.distances import to_closest_triangle, winding_numbers
from frontage.validation.tolerances import Tolerances


def check_indoor(
    graph: CellGraph, solids: Sequence[ValidSolid], owners: Sequence[str], tolerances: Tolerances
) -> list[Finding]:
    """Checks the valid cells of an IndoorGML model (`owners`: the cell of each solid) and their graph."""
    overlaps = [
        replace(f, code=701, message=f.message.replace("solids of one building", "cells"))
        for f in check_parts(solids, owners, tolerances)
    ]
    solid_of_cell = dict(zip(owners, solids, strict=True))
    links = _broken_links(graph)
    outside = _states_outside(graph, solid_of_cell)
    not_adjacent = [] if links else _cells_not_adjacent(graph, solid_of_cell, tolerances)
    return overlaps + outside + links + not_adjacent


def _states_outside(graph: CellGraph, solids: Mapping[str, ValidSolid]) -> list[Finding]:
    """702: the state of a cell lies outside of it."""
    findings = []
    for cell, state in graph.state_of_cell.items():
        if state in graph.position and cell in solids:
            solid = solids[cell]
            spot = np.array([graph.position[state]]) - solid.mesh.origin
            away, _ = to_closest_triangle(spot, solid.surface.corners)
            inside = abs(winding_numbers(spot, solid.surface.corners)[0]) >= 0.5
            if not inside and away[0] > solid.mesh.noise:
                text = f"the cell's state {state} lies {away[0]:.4g} m outside of it"
                findings.append(Finding(702, text, cell, "", graph.position[state]))
    return findings


def _broken_links(graph: CellGraph) -> list[Finding]:
    """703: a reference between cells, states and transitions has no target, or none back."""
    findings = []
    for cell, state in graph.state_of_cell.items():
        if state and graph.cell_of_state.get(state) != cell:
            problem = "does not exist"
            if state in graph.cell_of_state:
                problem = f"refers to {graph.cell_of_state[state] or 'no cell'}"
            findings.append(Finding(703, f"the cell refers to state {state}, which {problem}", cell))
    for state, cell in graph.cell_of_state.items():
        if cell and cell not in graph.state_of_cell:
            findings.append(Finding(703, f"the state refers to cell {cell}, which does not exist", state))
    for transition, ends in graph.ends.items():
        lost = [end for end in ends if end not in graph.cell_of_state]
        if lost or len(ends) != 2:
            what = f"{lost[0]}, which does not exist" if lost else f"{len(ends)} states instead of 2"
            findings.append(Finding(703, f"the transition connects {what}", transition))
    return findings


def _cells_not_adjacent(
    graph: CellGraph, solids: Mapping[str, ValidSolid], tolerances: Tolerances
) -> list[Finding]:
    """704: a transition connects cells that share no part of a face."""
    findings = []
    for transition, ends in graph.ends.items():
        pair = [solids[c] for e in ends if (c := graph.cell_of_state[e]) in solids]
        if len(pair) == 2 and not adjacent(pair[0], pair[1], tolerances):
            text = "the transition connects cells that share no part of a face"
            at = pair[0].location(pair[0].surface.corners.mean((0, 1)))
            findings.append(Finding(704, text, transition, "", at))
    return findings
