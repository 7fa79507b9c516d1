"""The truth about a scene: solids, true ortho-images, visibility, and the tables of `truth.json`.

`tables.scene_table` is the entry function. `solids.truth_solid` gives the LoD3 solid of a house,
`ortho.true_ortho` the true ortho-image of a facade, and `visibility.visibility` the share of each opening
that the sensors could see.
"""
