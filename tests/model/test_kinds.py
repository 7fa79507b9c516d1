"""The kinds of openings and protrusions and what is told of each."""

import json

import numpy as np
import pytest

from frontage.geometry.ring import rectangle
from frontage.model import DOORS, OPENING_SURFACES, Opening, OpeningKind, ProtrusionKind, Provenance


def test_every_opening_kind_has_a_letter_of_its_own_and_a_surface() -> None:
    assert len({kind.letter for kind in OpeningKind}) == len(OpeningKind)
    assert {kind.surface.semantics for kind in OpeningKind} == set(OPENING_SURFACES) == {"Window", "Door"}


def test_doors_are_the_kinds_that_one_goes_through() -> None:
    assert {"door", "garage", "passage"} == DOORS
    assert all(kind.at_ground for kind in DOORS)


def test_kinds_are_written_as_plain_text() -> None:
    assert json.dumps([*OpeningKind][:2]) == '["window", "door"]'
    assert f"{ProtrusionKind.AVANT_CORPS}" == "risalit"


def test_fronts_with_openings_belong_to_the_body() -> None:
    walls = {kind for kind in ProtrusionKind if kind.is_wall}
    assert walls < {kind for kind in ProtrusionKind if kind.is_body}
    assert not ProtrusionKind.BALCONY.is_body


def opening(kind: str) -> Opening:
    ring, zero = rectangle(0.0, 0.0, 1.0, 1.0), np.zeros((8, 8))
    return Opening("F/W0-1", kind, ring, zero, None, "rectangle", Provenance.MEASURED, 1.0, 1.0, 0, 1)


def test_an_opening_takes_its_kind_as_text_and_refuses_an_unknown_one() -> None:
    assert opening("garage").kind is OpeningKind.GARAGE
    with pytest.raises(ValueError, match="hatch"):
        opening("hatch")
