"""The published method: openings by cell decomposition (Becker & Haala 2008, sections 3.2.1 to 3.2.3).

`find_by_paper` is the entry. Edge points of the wall make lines, lines make partition planes, and the planes
make cells, which the share of the point-availability map within them classes as facade or window; rules of
neighbourhood settle doubtful cells.
"""
