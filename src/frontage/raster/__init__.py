"""Rasters: resampling, depth buffers, gridding, tiles. No project types, no named files."""
