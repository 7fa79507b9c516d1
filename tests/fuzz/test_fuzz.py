"""300 hostile files, in turn of every format: each is read, or refused in one clear sentence.

`make fuzz` tries 5,000. The docs say what counts as a failure (docs/reliability.md).
"""

from collections.abc import Iterator
from pathlib import Path

import pytest

from fuzz.harness import Harness, cases, judged, special_cases, unclear

CASES = 300
SEED = 20_261_122

PENDING: frozenset[str] = frozenset()
"""Formats with known failures. It is empty unless a reader is being repaired."""


@pytest.fixture(scope="module")
def harness(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Harness]:
    with Harness(tmp_path_factory.mktemp("fuzz")) as made:
        yield made


def test_the_undamaged_files_are_read(harness: Harness) -> None:
    outcomes = {seed.name: harness.undamaged(seed) for seed in harness.seeds}
    assert len(outcomes) > 50
    assert {name: o for name, o in outcomes.items() if o != ("read", "")} == {}


def test_hostile_files_are_read_or_refused_in_one_clear_sentence(harness: Harness) -> None:
    results = [harness.run(case) for case in cases(harness.seeds, CASES, SEED)]
    counts = {kind: sum(r.outcome == kind for r in results) for kind in ("read", "refused")}
    assert min(counts.values()) > CASES / 5
    failed = [r for r in results if r.failed and r.case.seed.name not in PENDING]
    assert not failed, "\n".join(f"{r.case.name}, {r.mutation}: {r.outcome}: {r.message}" for r in failed)


def test_what_is_no_regular_file_is_refused_at_once(harness: Harness) -> None:
    results = [harness.run(case) for case in special_cases(harness.seeds)]
    assert len({r.mutation for r in results}) == 6
    outside = [r for r in results if r.case.seed.reader != "run"]
    assert len(outside) > 200
    opened = [r for r in outside if r.mutation in ("folder", "fifo", "device") and r.outcome == "read"]
    assert not opened, "\n".join(f"{r.case.name}, {r.mutation}" for r in opened)
    failed = [r for r in results if r.failed and r.case.seed.name not in PENDING]
    assert not failed, "\n".join(f"{r.case.name}, {r.mutation}: {r.outcome}: {r.message}" for r in failed)


def test_a_case_can_be_repeated(harness: Harness) -> None:
    for case in cases(harness.seeds, len(harness.seeds), SEED):
        whole = harness.whole(case.seed)[1]
        assert case.data(whole) == case.data(whole)


@pytest.mark.parametrize(
    ("message", "fault"),
    [
        ("scan.las: the file is empty; export or copy it again", ""),
        ("scan.las: the file\nis empty", "more than one line"),
        ("scan.las: \x1b[31m is no number", "control characters"),
        ("the file is empty; export it again", "no file is named"),
        ("scan.las", "8 characters"),
        ("scan.las: " + "x" * 600, "610 characters"),
        ("scan.las: not readable (Unable to allocate 3 GiB)", "Unable to allocate"),
    ],
)
def test_what_a_clear_sentence_is(tmp_path: Path, message: str, fault: str) -> None:
    (tmp_path / "scan.las").touch()
    assert fault in unclear(message, tmp_path) and bool(fault) == bool(unclear(message, tmp_path))


def test_time_memory_and_death_are_failures(harness: Harness, tmp_path: Path) -> None:
    answer = {"outcome": "read", "message": "", "seconds": 0.1, "mb": 5}
    assert judged(answer, tmp_path) == ("read", "")
    assert judged(answer | {"seconds": 11.0}, tmp_path)[0] == "slow"
    assert judged(answer | {"mb": 2000}, tmp_path)[0] == "memory"
    for outcome in ("signal", "hang", "error", "nonsense"):
        assert judged(answer | {"outcome": outcome}, tmp_path)[0] == outcome
