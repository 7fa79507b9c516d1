"""Protrusions."""
