"""The statistics that the benchmarks print are right."""

import importlib.util
import time
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from frontage.model import Bar, Glazing
from frontage.model.built import TrueBar


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


def test_a_benchmark_writes_its_section_of_a_page_and_replaces_only_that(
    common: ModuleType, tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Results\n\nProse.\n")
    common.write_section(
        page, "bench_a.py", "python benchmarks/bench_a.py", "## Title\n\n| a |\n|---|\n| 1 |"
    )
    common.write_section(page, "bench_b.py", "python benchmarks/bench_b.py", "other")
    first = page.read_text()
    assert "Prose." in first and "### Title" in first and "| 1 |" in first
    common.write_section(page, "bench_a.py", "python benchmarks/bench_a.py --seeds 3", "| 2 |")
    second = page.read_text()
    assert "| 1 |" not in second and "| 2 |" in second and "--seeds 3" in second
    assert (
        second.count("begin bench_a.py") == 1
        and "other" in second
        and second.startswith("# Results\n\nProse.")
    )


def test_window_bars_are_judged_by_layout_and_by_length(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).resolve().parents[1] / "benchmarks"))
    score = importlib.import_module("_barscore")
    bars = (TrueBar("vertical", 0.6, (0.1, 1.9), 0.1), TrueBar("horizontal", 1.3, (0.1, 1.1), 0.06))
    truth = score.TrueLayout(bars, depth=0.15)
    pieces = (
        Bar("vertical", 0.61, (0.1, 1.27), 0.1, 0.005),
        Bar("vertical", 0.61, (1.33, 1.9), 0.1, 0.005),
        Bar("horizontal", 1.3, (0.1, 1.1), 0.08, 0.005),
    )
    right = score.judge("a", "w", truth, Glazing(True, pieces, confidence=0.9))
    assert right.exact and (right.hits, right.found, right.seen, right.true) == (3, 3, 2, 2)
    np.testing.assert_allclose(np.sort(right.errors[:, 0]), [0.0, 0.01, 0.01], atol=1e-9)
    half = score.judge("a", "w", truth, Glazing(True, pieces[1:], confidence=0.9))
    assert half.exact is False and (half.hits, half.found, half.seen) == (2, 2, 1)
    none = score.judge("a", "w", truth, Glazing(False))
    assert none.exact is False and not none.resolved and none.found == 0
    leaded = score.judge("a", "w", score.TrueLayout((), "leaded"), Glazing(True, pieces))
    assert leaded.exact is None and leaded.found == 0
    cells = score.summary([right, half, none, leaded])
    assert cells[0] == "3" and cells[1].startswith("33.3") and cells[2].startswith("66.7")
