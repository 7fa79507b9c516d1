"""The statistics that the benchmarks print are right."""

import importlib.util
import time
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest


@pytest.fixture(scope="module")
def common() -> ModuleType:
    path = Path(__file__).resolve().parents[1] / "benchmarks" / "_common.py"
    spec = importlib.util.spec_from_file_location("_common", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_bootstrap_covers_the_mean_as_often_as_it_says(common: ModuleType) -> None:
    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(200):
        _, low, high = common.bootstrap(rng.normal(5.0, 1.0, 40), np.mean, draws=300)
        hits += low <= 5.0 <= high
    assert 0.88 <= hits / 200 <= 0.99


def test_an_empty_set_of_cases_is_refused(common: ModuleType) -> None:
    with pytest.raises(ValueError, match="no values"):
        common.bootstrap([])


def test_the_wilson_interval_matches_the_textbook(common: ModuleType) -> None:
    p, low, high = common.rate_interval(9, 10)
    assert (p, round(low, 3), round(high, 3)) == (0.9, 0.596, 0.982)
    assert common.rate_interval(10, 10)[2] == 1.0


def test_a_time_ratio_tells_slow_from_fast(common: ModuleType) -> None:
    ratio, low, high = common.time_ratio(lambda: time.sleep(0.06), lambda: time.sleep(0.02))
    assert 1.5 < ratio < 6 and low <= ratio <= high
