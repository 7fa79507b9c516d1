"""Borders."""
