"""Street fronts: where walls stand, the lines they form, the side of the street, and the profile along each.

`map_walls` accumulates upright planar cells into columns, `find_fronts` draws street fronts through them, and
`front_profile` describes a front from left to right. Paper A has no such step; there, a component is a house.
"""
