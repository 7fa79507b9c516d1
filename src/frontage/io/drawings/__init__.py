"""Elevations of facades as drawings: DXF for CAD, PDF for paper."""
