"""Photos oriented to one another (image to image): key points, pairs, matches, blocks.

The order is that of the functions::

    points = [key_points(image) for image in images]                    # features.py
    for i, j in candidate_pairs(photos, points):                        # pairs.py
        match_pair(points[i], points[j], camera_i, camera_j)            # relative.py, repetition.py
    build_blocks(photos, points, pairs)                                 # mapping.py
"""

from frontage.orientation.ties.features import key_points
from frontage.orientation.ties.mapping import Blocks, build_blocks
from frontage.orientation.ties.options import TieOptions
from frontage.orientation.ties.pairs import candidate_pairs
from frontage.orientation.ties.relative import match_pair

__all__ = ["Blocks", "TieOptions", "build_blocks", "candidate_pairs", "key_points", "match_pair"]
