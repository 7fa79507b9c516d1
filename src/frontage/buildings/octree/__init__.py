"""The octree of the street cloud and its connected components (paper A, section 2.1).

`build_octree` distributes the points into cells; `component_buildings` is the paper's own building detection.
"""
