"""Bundles for users: the textured facade model."""

from frontage.exports.facades import FacadePicture, facade_mesh, limit_texture, triangulate

__all__ = ["FacadePicture", "facade_mesh", "limit_texture", "triangulate"]
