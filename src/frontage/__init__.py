"""Measured facades from laser scans and photographs of a street."""

__version__ = "0.1.0"
