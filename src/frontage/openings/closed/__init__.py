"""Finds openings that are closed level with the wall, by how they look: shutters, panes, grilles.

This goes beyond paper B, whose windows are gaps in the points. `find_closed_openings` is the entry: it looks
along the rows and columns of the other openings for shapes like theirs across whose sides relief, intensity
or colour step by the same amount.
"""
