"""Citymodels."""
