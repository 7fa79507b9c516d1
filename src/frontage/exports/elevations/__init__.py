"""Elevations of facades: what a drawing shows of what was measured."""

from frontage.exports.elevations.draw import draw_elevation

__all__ = ["draw_elevation"]
