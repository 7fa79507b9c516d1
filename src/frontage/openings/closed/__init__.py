"""Closed."""
