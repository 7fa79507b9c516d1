"""Installations: balconies, awnings, cornices and the like as closed solids of their own against a wall.

CityGML calls them BuildingInstallation; they are no part of the building's volume. The entry function is
`attach.attach`.
"""
