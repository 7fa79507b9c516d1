"""Streets: plots in a row on both sides of a road, with ground, hedges, trees, cars, lamps and pedestrians.

`build.build_street` is the entry function: it turns a `SceneSpec` into a `Scene`.
"""
