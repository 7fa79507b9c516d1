"""Operations on rasters: resampling, depth buffers, gridding and tiles.

`resample.resample` is the resampling of paper A, section 3.2, free of aliasing; `sourcemap` holds the maps
that it follows, `zbuffer` the depth buffers that tell what is hidden, `gridding` turns scattered points into
grids, and `interpolation` tells the values between their cells.
Nothing here knows the project's types or named files, and there is no single entry function.
"""
