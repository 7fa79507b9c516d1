"""Compares results with the truth of a simulated or annotated scene.

Every `score_...` function matches one kind of result (buildings, facades, openings, protrusions,
ortho-images, poses) with the truth one to one and returns a `metric.ScorePart`: metrics with 95 % intervals
and one row per item. The metrics correspond to the results of both papers (A, section 4; B, sections 2 and
3), and the reported standard errors are tested against the actual errors.
"""
