"""What the laser beams say about a wall: where they hit it, went through it, or were stopped before it.

Paper B, section 3.2.1, takes gaps in the points for openings; this sub-room also uses the lines of sight, so
that a shadow is not taken for a window. `sort_beams` sorts the beams at the depth that the wall has locally;
`weigh` turns them into log-likelihood ratios of open against solid on a raster, which beams without return
(`with_lost_beams`) and shallow panels (`without_panels`) complete.
"""
