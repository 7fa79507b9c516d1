"""The LoD3 model on the page."""

from frontage.report.model import model_facts, model_remarks

ABOUT = {
    "lod": "3", "host": "cloud", "openings_found": 12, "openings_built": 11, "installations": ["P1"],
    "offsets": {"W1": -0.15, "W2": 0.05, "W3": 0.1},
    "refused": [{"code": "S311", "message": "W4: no room", "hint": ""}], "notes": ["W2: made flush"],
}  # fmt: skip


def test_facts_say_host_counts_and_offsets() -> None:
    facts = {f.name: f.value for f in model_facts(ABOUT)}
    assert facts["Model"] == "LoD3" and "no city model" in facts["Host"]
    assert facts["Openings"] == "11 of 12" and facts["Installations"] == "1"
    assert facts["Offset"] == "median 100 mm, at most 150 mm"
    assert "Offset" not in {f.name for f in model_facts({**ABOUT, "offsets": {}, "lod": "2"})}


def test_remarks_begin_with_what_is_missing() -> None:
    assert model_remarks(ABOUT) == ["S311 W4: no room", "W2: made flush"]
