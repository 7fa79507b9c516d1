"""Cityjson."""
