"""Checks of the photos before they paint: which are left out or turned, and why none shows a facade."""
