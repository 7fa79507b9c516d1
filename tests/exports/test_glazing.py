"""What is known of frames and bars, as attributes of windows."""

from dataclasses import replace

import numpy as np

from frontage.exports.glazing import attributes_of_glazing
from frontage.model import Estimate, Glazing
from opening_fakes import opening


def test_bars_are_counted_and_placed_from_the_borders_of_the_opening() -> None:
    found = attributes_of_glazing(opening())
    assert (found["n_vertical"], found["n_horizontal"], found["bars_confidence"]) == (1, 1, 0.875)
    assert (found["vertical_positions"], found["vertical_widths"]) == ("0.6000", "0.0600")
    assert (found["horizontal_positions"], found["horizontal_widths"]) == ("1.0000", "0.0500")
    assert found["sigma_vertical_positions"] == 0.004 and "sigma_horizontal_positions" not in found
    assert (found["frame_width"], found["sigma_frame_width"], found["frame_depth"]) == (0.07, 0.004, 0.125)
    assert "bars" not in found


def test_a_single_pane_has_no_bars_and_that_is_an_answer() -> None:
    found = attributes_of_glazing(replace(opening(), glazing=Glazing(True, confidence=0.97)))
    assert found == {"n_vertical": 0, "n_horizontal": 0, "bars_confidence": 0.97}


def test_what_is_not_known_is_not_counted() -> None:
    assert attributes_of_glazing(replace(opening(), glazing=None)) == {"bars": "not measured"}
    width = Estimate(0.06, np.full((1, 1), np.inf), 1.0)
    coarse = Glazing(False, frame_width=width, note="a pixel is 21 mm wide")
    found = attributes_of_glazing(replace(opening(), glazing=coarse))
    assert found == {"bars": "not resolved: a pixel is 21 mm wide", "frame_width": 0.06}
