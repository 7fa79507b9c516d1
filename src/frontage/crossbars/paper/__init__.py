"""The published method: crossbars from matched edges (Becker & Haala 2008, section 3.3).

`find.bars_by_edges` is the entry. Straight 2-D edges of photos are matched within windows and triangulated.
The window is divided recursively, and a division is accepted where 3-D edges lie along the dividing line.
"""
