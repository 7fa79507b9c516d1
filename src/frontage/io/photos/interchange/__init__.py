"""Cameras and poses in the formats of other photogrammetric programs, read and written.

Every module states the conventions of its format: the axes of the camera, the direction of the rotation, the
origin of the pixels and the order of the distortion parameters. All are converted to Frontage's own: COLMAP's
camera (x right, y down, z forward, first pixel centre at 0.5) in a world that is east, north, up.
"""
