"""COLMAP's camera models."""
