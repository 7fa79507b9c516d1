"""Finds what stands out of a wall or is set back from it: balconies, oriels, cornices, bands, set-back parts.

Paper B, section 3.2.3, adds protrusions where points in front of the plane fill a cell. Here
`find_protrusions` cuts connected points into flat fronts and mouldings, keeps what is framed by straight
borders and attached to the wall, and measures each border between the beams that the front stopped and those
that passed beside it.
"""
