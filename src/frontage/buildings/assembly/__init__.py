"""Put the split together: segments of fronts become buildings, and every point gets its place.

The entry function is `assign_points`; `collect` makes the result also of the paper's own components.
"""
