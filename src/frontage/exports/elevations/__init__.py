"""Elevations of facades: what a drawing shows of what was measured."""

from frontage.exports.elevations.draw import UNCERTAIN_M, bounds_of, draw_elevation, title_block

__all__ = ["UNCERTAIN_M", "bounds_of", "draw_elevation", "title_block"]
