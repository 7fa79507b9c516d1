"""Scoring of protrusions: what counts as found, as missed, as wrongly found."""

import numpy as np
import pytest

from frontage.evaluation.protrusions import score_protrusions
from frontage.evaluation.result import FoundProtrusion
from frontage.evaluation.truth import TrueFacade, TrueProtrusion, Truth
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model import WorldRef

FRAME = Rigid3("local", "facade", np.eye(3), np.array([100.0, 50.0, 2.0]))


def truth(*protrusions):
    facade = TrueFacade("B01/F1", "B01", FRAME, rectangle(0, 0, 10, 12), (), {}, None, protrusions)
    return Truth("test", WorldRef(np.zeros(3, np.int64)), (), (facade,))


def true(kind, box, front):
    return TrueProtrusion(f"B01/F1/{kind}", kind, rectangle(*box), (front, 0.0))


def claim(kind, box, front, sigma=0.005):
    ring = rectangle(*box)
    xyz = FRAME.apply(np.column_stack([ring[:, 0], np.full(4, front), ring[:, 1]]))
    return FoundProtrusion("B01/F1/P1", kind, xyz, sigma, 0.001)


def value(part, name):
    return part.figures[name].value


def test_a_found_balcony_scores_with_its_errors():
    part = score_protrusions(
        truth(true("balcony", (2, 3, 4, 4.2), -1.0)), [claim("balcony", (2.01, 3, 4.01, 4.2), -0.998)]
    )
    assert (value(part, "recall_50"), value(part, "precision_50"), value(part, "kind_right")) == (1, 1, 1)
    assert value(part, "front_bias") == pytest.approx(0.002)
    assert value(part, "border_left_bias") == pytest.approx(0.01)
    assert value(part, "border_top_bias") == pytest.approx(0.0, abs=1e-9)


def test_missed_and_wrong_ones_count():
    part = score_protrusions(truth(true("oriel", (2, 3, 4, 7), -0.6)), [claim("balcony", (6, 3, 8, 4), -1.0)])
    assert (value(part, "recall_50"), value(part, "precision_50")) == (0, 0)


def test_steps_and_eaves_do_not_count_as_wrongly_found():
    found = [claim("steps", (1, 0, 2, 0.4), -0.6), claim("cornice", (0, 11.5, 10, 11.8), -0.4)]
    part = score_protrusions(truth(true("oriel", (2, 3, 4, 7), -0.6)), found)
    assert value(part, "precision_50") is None
    assert value(part, "recall_50") == 0


def test_tiers_of_a_cornice_count_as_one():
    tiers = [true("cornice", (0, 11 + k / 10, 10, 11.1 + k / 10), -0.1 - k / 10) for k in (1, 2, 3)]
    part = score_protrusions(truth(*tiers), [claim("cornice", (0, 11.1, 10, 11.4), -0.4)])
    assert value(part, "recall_cornice_50") == 1
    assert part.figures["recall_cornice_50"].n == 1
    assert value(part, "front_bias") == pytest.approx(0.0, abs=1e-9)


def test_low_relief_cannot_be_missed():
    part = score_protrusions(truth(true("string", (0, 4, 10, 4.2), -0.06)), [])
    assert part.figures["recall_string_50"].n == 0


def test_what_lies_on_another_facade_is_not_counted():
    far = FoundProtrusion("B02/F1/P1", "balcony", claim("balcony", (2, 3, 4, 4), -1.0).ring + 50.0)
    part = score_protrusions(truth(true("balcony", (2, 3, 4, 4.2), -1.0)), [far])
    assert part.figures["precision_50"].value is None
    assert value(part, "recall_50") == 0
