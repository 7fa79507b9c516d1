"""Geometry of polygon meshes for the validator: planes, triangulations, exact predicates and distances.

`mesh.weld` makes the meshes. Exact tests (`predicates`, `triangle_pairs`) work on integer coordinates;
measurements (`distances`, `intersection_lines`) work in floating point with a noise threshold.
"""
