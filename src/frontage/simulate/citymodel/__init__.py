"""Citymodel."""
