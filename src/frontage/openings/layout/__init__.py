"""Finds where openings are: candidate rectangles of open cells, their best layout, and predicted ones.

Paper B, section 3.2.2, classifies cells and lets neighbouring windows decide doubtful ones; here `find_boxes`
chooses the set of rectangles worth most by an integer programme. `pool` lets rows, columns and sizes share
what they have in common, `infer` predicts openings that nothing saw, and `without_overlaps` leaves one of
those that overlap.
"""
