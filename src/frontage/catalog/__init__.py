"""The names of things: floors, bays and identifiers of openings, and buildings by their address.

`number_building` is the entry function: it finds the storeys and bays of a building and names its openings,
so that "the second window of the third floor of 13 rue Soufflot" (paper A, section 3.2) has an identifier.
`find_building` finds a building by its id or by an address, however that is written.
"""

from frontage.catalog.addresses import find_building
from frontage.catalog.numbering import number_building, number_facade

__all__ = ["find_building", "number_building", "number_facade"]
