"""What things are called: floors, bays and ids of openings, buildings by their address."""

from frontage.catalog.numbering import number_building, numbered

__all__ = ["number_building", "numbered"]
