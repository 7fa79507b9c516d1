"""Streets with exact truth: scenes, scanners, cameras. No estimator imports this package."""
