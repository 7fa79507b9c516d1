"""Cut a front into houses: change points of its profile, kept where independent cues agree.

The entry function is `find_cuts`. Paper A separates buildings only where their point clouds do not touch;
this step divides a terrace, with the help of footprints where a map is given.
"""
