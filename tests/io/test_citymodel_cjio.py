"""Models rewritten by cjio hold the same buildings in another layout."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from city_files import house
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from io_files import UTM
from realdata import data_path

CJIO = Path(sys.executable).with_name("cjio")


@pytest.mark.parametrize("source", ["ours", "theirs"])
def test_models_rewritten_by_cjio_are_read_the_same(tmp_path: Path, source: str) -> None:
    path = tmp_path / "m.city.json"
    if source == "ours":
        write_cityjson(path, [house("A", 0), house("B", 8)], UTM, "two houses")
    else:
        path = data_path("ingolstadt_scene/input/lod2/lod2.city.json")
    steps = [["export", "jsonl", "x.city.jsonl"], ["vertices_clean", "save", "clean.city.json"]]
    wanted = read_city_model(path, UTM)
    for step in steps:
        out = tmp_path / step[-1]
        subprocess.run([str(CJIO), str(path), *step[:-1], str(out)], check=True, capture_output=True)
        found = read_city_model(out, UTM)
        assert {b.id: b.address for b in found.buildings} == {b.id: b.address for b in wanted.buildings}
        by_id = {b.id: b for b in found.buildings}
        for b in wanted.buildings:
            for one, other in zip(b.shells, by_id[b.id].shells, strict=True):
                for s, t in zip(one.surfaces, other.surfaces, strict=True):
                    assert (s.semantics, s.source_id) == (t.semantics, t.source_id)
                    np.testing.assert_allclose(s.ring, t.ring, atol=6e-4)
