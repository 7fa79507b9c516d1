"""Openings and protrusions of a facade, from its points and their lines of sight."""
