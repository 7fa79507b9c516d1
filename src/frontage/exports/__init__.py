"""Bundles for users: the textured facade model, buildings for a city model."""

from frontage.exports.facades import FacadePicture, facade_mesh, limit_texture, triangulate

__all__ = ["FacadePicture", "facade_mesh", "limit_texture", "triangulate"]
