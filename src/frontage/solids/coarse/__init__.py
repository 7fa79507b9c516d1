"""The coarse solids that openings are cut into ("hosts"): the existing coarse building model of paper B.

They come from a city model whose polygons are closed to a solid, or from blocks behind the measured facades.
The entry function is `choose.coarse_model`; `reseat.reseat_walls` moves their walls onto the measured planes.
"""
