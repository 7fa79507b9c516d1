"""Killed runs: no process is left, and the resumed run has the bytes of one that was left alone."""

import signal
import time
from pathlib import Path

import pytest

from fuzz.kills import HANGS_S, Run, Whole, contents, killed_often, markers, moments, small_street, unkilled


@pytest.fixture(scope="module")
def street(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project file of two houses."""
    return small_street(tmp_path_factory.mktemp("kills"))


@pytest.fixture(scope="module")
def whole(street: Path, tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """A run with one worker that was left alone."""
    return unkilled(street, tmp_path_factory.mktemp("whole") / "out", 1)


def test_a_run_that_is_ended_and_killed_twice_is_resumed_to_the_same_bytes(
    street: Path, whole: Whole, tmp_path: Path
) -> None:
    """With one worker, tests/pipeline/test_run.py does the same at fourteen places of a run."""
    ended_by_sigterm(street, tmp_path / "killed2_0", 2, whole)
    kills = killed_often(street, tmp_path, whole, 2, 2, seed=2)
    assert kills[0].markers < whole.markers and kills[0].markers <= kills[1].markers
    assert [kill for kill in kills if kill.orphans] == []


def test_workers_end_with_their_parent(street: Path, tmp_path: Path) -> None:
    run = Run(street, tmp_path / "out", 2)
    try:
        while not any("spawn_main" in line for line in run.alive()):
            assert run.process.poll() is None
            time.sleep(0.01)
        run.kill()
        assert run.orphans() == ()
    finally:
        run.clean()


def test_sigterm_ends_a_run_of_one_worker(street: Path, whole: Whole, tmp_path: Path) -> None:
    """tests/cli/test_cli.py resumes one that Ctrl-C has ended."""
    ended_by_sigterm(street, tmp_path / "out", 1, whole)


def ended_by_sigterm(street: Path, out: Path, workers: int, whole: Whole) -> None:
    """End a run into the folder `out` early: it stops in one sentence, before its work is done."""
    run = Run(street, out, workers)
    try:
        _until_working(run, out)
        run.process.send_signal(signal.SIGTERM)
        code, said = run.wait(HANGS_S)
        assert code == 130, said
        assert markers(out) < whole.markers
        assert "\n" not in said.strip(), said
        assert said.strip().startswith("interrupted")
        assert run.orphans() == ()
    finally:
        run.clean()


def test_a_process_that_works_on_is_an_orphan(street: Path, tmp_path: Path) -> None:
    run = Run(street, tmp_path / "out", 1)
    try:
        (told,) = run.orphans()
        assert "frontage" in told
        run.kill()
        assert run.orphans() == ()
    finally:
        run.clean()


def _until_working(run: Run, out: Path) -> None:
    """Wait until the first stage is finished."""
    end = time.monotonic() + HANGS_S
    while not (out / ".done" / "scans.json").exists():
        assert run.process.poll() is None and time.monotonic() < end
        time.sleep(0.02)
    time.sleep(0.2)


def test_the_moments_of_kills_are_spread_over_the_whole_run() -> None:
    shares = sorted(moments(10, seed=3))
    assert all(k / 10 <= share < (k + 1) / 10 for k, share in enumerate(shares))
    assert moments(10, seed=3) == moments(10, seed=3) != sorted(moments(10, seed=3))


def test_results_are_compared_without_timings(tmp_path: Path) -> None:
    for name in ("manifest.json", ".lock", ".done/scans.json", "model/a.glb"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)
    assert list(contents(tmp_path)) == ["model/a.glb"]
