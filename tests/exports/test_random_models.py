"""Random models pass the official schemas and val3dity's rules (`bench_models.py` makes hundreds of them)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from random_models import KINDS, RandomModel, faults, random_models

SMALL = 1  # a street whose houses have few openings


@pytest.fixture(scope="module")
def models() -> list[RandomModel]:
    return random_models(SMALL)


def test_random_models_are_faultless(tmp_path: Path, models: list[RandomModel]) -> None:
    assert {"2", "3", "installation", "frame"} <= set().union(*(m.levels for m in models))
    assert all(m.textures for m in models) and sum(m.elements for m in models) > 10
    assert [text for m in models for text in faults(m, tmp_path)] == []


def test_faults_are_found(tmp_path: Path, models: list[RandomModel]) -> None:
    """A corner that is moved by 20 cm opens the solid, and an installation in the wall overlaps it."""
    (house,) = models[0].buildings
    fine = next(s for s in house.shells if s.lod == "3" and not s.installation)
    ring = np.array(fine.surfaces[0].ring)
    ring[0] += 0.2
    open_shell = replace(fine, surfaces=(replace(fine.surfaces[0], ring=ring), *fine.surfaces[1:]))
    other = replace(house, shells=tuple(open_shell if s is fine else s for s in house.shells))
    told = faults(replace(models[0], buildings=(other,)), tmp_path, KINDS[1:])
    assert {" ".join(text.split()[1:3]).rstrip(":") for text in told} == set(KINDS[1:])
    assert any(f" {code} " in text for text in told for code in (203, 302, 303, 305, 306))
    doubled = replace(fine, installation=True, part=f"{house.id}-again", textures={})
    inside = replace(house, shells=(*house.shells, doubled))
    assert any(
        " 601 " in text for text in faults(replace(models[0], buildings=(inside,)), tmp_path, KINDS[1:2])
    )
