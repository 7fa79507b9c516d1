"""Wall planes: the search (paper A, section 2.1), the robust fit, the refinement and its covariance.

`search_plane` finds a plane among thinned points, `connected_plane` fits it to its largest connected
component, and `refine_wall` takes all points. `paper_plane` is the paper's own method, kept as the baseline.
"""
