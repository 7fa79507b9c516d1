"""Pure mathematics on arrays: rigid motions, cameras and lenses, planes, rings and homographies.

The axes of the facade frame are those of paper A, section 2.2 (`plane.facade_axes`); the homography is that
of section 3.1 (`homography.homography_from_pose`, `homography_from_pairs`). Nothing here knows the project's
types or reads files, and there is no entry function: every module stands for itself.
"""
