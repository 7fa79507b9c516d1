"""openings.json and protrusions.json: what stands in them, and that reading them back loses nothing."""

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from facade_fakes import facade
from frontage.errors import FileError
from frontage.model import Bar, Elements, Estimate, Facade, Glazing
from frontage.pipeline.store.elements import FOUND, PRODUCT, check_elements, load_elements, save_product
from frontage.pipeline.store.elements import save_elements as save_found
from opening_fakes import elements, opening, round_door

FILES = (PRODUCT, *FOUND[1:])


def save_elements(folder: Path, facade: Facade, elements: Elements) -> None:
    """What the stages `openings` and `crossbars` leave."""
    save_found(folder, facade, elements)
    save_product(folder, facade, elements)


def same(a: Any, b: Any) -> bool:
    """Whether two nouns are equal to the last bit."""
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, Estimate) or hasattr(a, "__dataclass_fields__"):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return bool(a == b)


def test_what_was_saved_is_read_back_exactly(tmp_path):
    save_elements(tmp_path, facade(), elements())
    assert same(elements(), load_elements(tmp_path, "B01/F1"))
    assert not same(elements().openings[0], elements().openings[1])


def test_a_facade_without_openings_has_empty_lists(tmp_path):
    save_elements(tmp_path, facade(), Elements("B01/F1", ()))
    assert json.loads((tmp_path / "openings.json").read_text()) == []
    assert load_elements(tmp_path, "B01/F1").openings == ()


def test_the_same_elements_give_the_same_bytes(tmp_path):
    for name in "ab":
        (tmp_path / name).mkdir()
        save_elements(tmp_path / name, facade(), elements())
    for file in FILES:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_the_documented_keys_of_openings(tmp_path):
    save_elements(tmp_path, facade(), elements())
    window, door, front = json.loads((tmp_path / "openings.json").read_text())
    assert window["sigma"] == pytest.approx(
        {"left": 0.003, "bottom": 0.004, "right": 0.005, "top": 0.006, "depth": 0.007}
    )
    assert (window["kind"], window["floor"], window["bay"], window["depth"]) == ("window", 1, 1, 0.1 + 0.02)
    assert window["provenance"] == "measured" and door["provenance"] == "inferred"
    assert window["bars"]["vertical"][0]["position"] == -2.5
    assert window["bars"]["horizontal"][0]["extent"] == [-3.1, -1.9]
    assert door["depth"] is None and door["sigma"]["depth"] is None
    f = facade()
    xyz = f.frame.inverse.apply(f.world.to_local(np.array(window["outline_world"])))
    np.testing.assert_allclose(xyz[:, [0, 2]], opening().ring, atol=1e-9)
    np.testing.assert_allclose(xyz[:, 1], 0.0, atol=1e-9)
    assert front["on"] == "B01/F1/P1"
    xyz = f.frame.inverse.apply(f.world.to_local(np.array(front["outline_world"])))
    np.testing.assert_allclose(xyz[:, 1], -0.9, atol=1e-9)


def test_protrusions_stand_at_their_front(tmp_path):
    save_elements(tmp_path, facade(), elements())
    (balcony,) = json.loads((tmp_path / "protrusions.json").read_text())
    assert balcony["front"] == -0.9 and balcony["sigma"] == {"border": 0.02, "front": None}
    f = facade()
    xyz = f.frame.inverse.apply(f.world.to_local(np.array(balcony["outline_world"])))
    np.testing.assert_allclose(xyz[:, 1], -0.9, atol=1e-9)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("kind", 3, "kind = 3 is no text"),
        ("outline", [[0, 0], [1, 0]], "no ring"),
        ("outline", [[0, 0], [1, 0], [1, "1"], [0, 1]], "outline = '1' is no number"),
        ("outline", [[0, 0], [1, 0], [1, 1]], "ring_covariance"),
        ("provenance", "guessed", "guessed"),
        ("floor", 1.5, "floor = 1.5 is no whole number"),
        ("depth", float("nan"), "depth = nan is no number"),
        ("depth_estimate", {"variance": 1.0, "dof": 3.0}, "lacks 'provenance'"),
        ("bars", {"vertical": []}, "lacks 'horizontal'"),
        ("bars", {"vertical": [{"position": "left"}], "horizontal": []}, "lacks 'extent'"),
        ("bars", {"vertical": [3], "horizontal": []}, "not subscriptable"),
        ("glazing", 3, "not subscriptable"),
        ("glazing", {"resolved": True}, "lacks 'frame_width'"),
    ],
)
def test_a_garbled_entry_is_named(tmp_path, key, value, told):
    save_elements(tmp_path, facade(), elements())
    path = tmp_path / "openings.json"
    table = json.loads(path.read_text())
    table[0][key] = value
    path.write_text(json.dumps(table))
    with pytest.raises(FileError) as caught:
        load_elements(tmp_path, "B01/F1")
    assert str(caught.value).startswith(f"{path}: B01/F1/W1-1") and told in str(caught.value)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("resolved", 1, "resolved = 1 is neither true nor false"),
        ("confidence", "high", "confidence = 'high' is no number"),
        ("note", None, "note = None is no text"),
        ("frame_width", {"value": float("inf")}, "frame_width = inf is no number"),
        ("depth", {"value": 0.1, "variance": 1.0, "dof": 3.0}, "lacks 'provenance'"),
        ("sources", 7, "not iterable"),
    ],
)
def test_a_garbled_glazing_is_named(tmp_path, key, value, told):
    save_elements(tmp_path, facade(), elements())
    path = tmp_path / "openings.json"
    table = json.loads(path.read_text())
    table[0]["glazing"][key] = value
    path.write_text(json.dumps(table))
    with pytest.raises(FileError) as caught:
        load_elements(tmp_path, "B01/F1")
    assert str(caught.value).startswith(f"{path}: B01/F1/W1-1") and told in str(caught.value)


def test_unresolved_glazing_and_unknown_errors_come_back(tmp_path):
    lost = Glazing(False, note="too dark", sources=("IMG_1.jpg",))
    bare = Glazing(True, (Bar("vertical", 0.5, (0.0, 1.0), 0.03, float("inf")),))
    for glazing in (lost, bare, Glazing(True)):
        found = Elements("B01/F1", (replace(opening(), glazing=glazing),))
        save_elements(tmp_path, facade(), found)
        assert same(found, load_elements(tmp_path, "B01/F1"))
    assert not same(found, Elements("B01/F1", (replace(opening(), glazing=lost),)))


def test_what_files_cannot_hold_is_told_before(tmp_path):
    found = elements()
    assert check_elements(found) is found
    broken = replace(found.openings[0], depth=Estimate(float("nan"), np.eye(1), 3.0))
    with pytest.raises(ValueError, match=r"B01/F1/W1-1: its outline, depth"):
        check_elements(replace(found, openings=(broken,)))
    with pytest.raises(ValueError, match=r"B01/F1/W0-2: it is on B01/F1/P1, which was not found"):
        check_elements(replace(found, protrusions=()))
    front = replace(found.protrusions[0], confidence=float("inf"))
    with pytest.raises(ValueError, match=r"B01/F1/P1: .* confidence"):
        check_elements(replace(found, protrusions=(front,)))


@pytest.mark.parametrize("file", FILES)
def test_missing_and_damaged_files_say_which(tmp_path, file):
    save_elements(tmp_path, facade(), elements())
    whole = (tmp_path / file).read_bytes()
    for damage in (whole[: len(whole) // 2], b"", b'{"a": 1}'):
        (tmp_path / file).write_bytes(damage)
        with pytest.raises(FileError, match=file) as caught:
            load_elements(tmp_path, "B01/F1")
        assert "frontage openings" in str(caught.value)
    (tmp_path / file).unlink()
    with pytest.raises(FileError, match=f"{file}: no such file"):
        load_elements(tmp_path, "B01/F1")


def test_outlines_of_another_list_are_refused(tmp_path):
    save_elements(tmp_path, facade(), elements())
    more = tmp_path / "more"
    more.mkdir()
    save_elements(more, facade(), Elements("B01/F1", (opening(), round_door())))
    (more / "outlines.npz").replace(tmp_path / "outlines.npz")
    with pytest.raises(FileError, match=r"outlines\.npz"):
        load_elements(tmp_path, "B01/F1")
