"""Geometry of polygon meshes for the validator: planes, triangulations, exact predicates and distances.

`mesh.weld` makes the meshes. What decides on exact grounds (`predicates`, `triangle_pairs`) works on integer
coordinates; what measures (`distances`, `intersection_lines`) works in floating point with a noise threshold.
"""
