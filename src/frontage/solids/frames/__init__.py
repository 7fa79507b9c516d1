"""Window frames with their bars: closed solids that stand in the openings of the fine solids.

They are no part of the building's shell. The entry function is `seat.window_frames`.
"""
