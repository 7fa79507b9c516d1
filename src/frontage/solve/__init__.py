"""Estimation on arrays: RANSAC, robust fits, correlated residuals and change points.

`ransac.lo_ransac` is the RANSAC of paper A, section 2.1, with local optimisation; it serves every minimal
problem of the project. `robust.irls` refines what it finds, and `correlation.fit_covariance` gives the result
an honest covariance although the residuals are correlated.
"""
