"""Photographs: their cameras, their poses, and their pixels when these are asked for.

`read.read_photos` is the entry function: it takes cameras and poses from one of the formats in `formats.py`
and checks them against the picture files. The poses are the input of paper A's projection (section 3) and of
paper B's alignment (section 2.2).
"""
