"""Cuts reliefs into a coarse solid by cell decomposition: paper B, section 3.1, and the cut of section 3.2.3.

A wall is partitioned into conforming cells, each at one depth; the boundary between solid and void over these
cells replaces the wall's faces. The entry function is `build.build_solid`.
"""
