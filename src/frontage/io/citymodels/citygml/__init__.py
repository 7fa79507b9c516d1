"""Citygml."""
