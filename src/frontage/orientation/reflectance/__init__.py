"""Reflectance images of scans: what a scan would look like in a photo, with a 3-D point behind every pixel.

`surface.scanned_surface` prepares the points once (tones corrected for range and incidence), `render` draws
them as a photo or a wall would show them, `raster` gives the picture in the scanner's own raster.
"""
