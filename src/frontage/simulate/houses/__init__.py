"""Houses: drawn from a specification or a seed, with facades, openings, roofs and rooms.

`draft.draft_house` settles the measures of a house, and `house.build_house`, the entry function, turns them
into triangles and into the plan that is its truth. For that, `style` draws the types of windows, `layout` and
`groundfloor` place them on the front, and `compose` collects all that belongs to one facade in an elevation.
"""
