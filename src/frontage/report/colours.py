"""Colours of drawn openings by where they come from, RGB; page.css has the same."""

from frontage.model import Provenance

COLOURS = {
    Provenance.MEASURED: (46, 229, 157),
    Provenance.POOLED: (77, 184, 255),
    Provenance.INFERRED: (255, 159, 28),
    Provenance.GIVEN: (255, 255, 255),
}
