"""Estimation on arrays: one LO-RANSAC, robust fits, correlated residuals, least squares."""
