"""What things are called: floors, bays and ids of openings, buildings by their address."""

from frontage.catalog.addresses import find_building
from frontage.catalog.numbering import number_building, numbered

__all__ = ["find_building", "number_building", "numbered"]
