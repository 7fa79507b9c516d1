"""Files to nouns and back: one module per format, one registry (`formats.py`) per kind of file.

The entry functions are `scans.read.read_scans`, `photos.read.read_photos`, `citymodels.read.read_city_model`,
`shapes.read.read_shapes` and `rasters.ortho.read_ortho`. Besides the run folder's store, this room is the
only one that opens files; it covers the input data of paper A (section 2) and paper B (section 2).
"""
