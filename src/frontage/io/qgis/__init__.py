"""Writes project files of QGIS (version 3.22 or newer)."""
