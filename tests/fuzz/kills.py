"""Kills runs at random moments and resumes them: nothing is lost, and nobody outlives the run.

`python -m fuzz.kills` does it many times; see `make fuzz`. A run is started in a session of its own and
with a mark in its environment, by which its processes are found in /proc.
"""

import argparse
import hashlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

WORKS_ON_S = 1.0  # of processor time: a process of a killed run that uses more has not noticed
HANGS_S = 100.0  # by the clock, which a busy machine stretches: whatever lives so long never ends
_MARK = "FRONTAGE_KILL_TEST"
_UNEQUAL = ("manifest.json", ".lock")  # holds timings; tells who runs


@dataclass(frozen=True)
class Whole:
    """A run that was left alone: the hashes of its results, how long it took, how many markers it put."""

    contents: dict[str, str]
    seconds: float
    markers: int


@dataclass(frozen=True)
class Kill:
    """A kill: how many markers there were, and which processes lived on."""

    markers: int
    orphans: tuple[str, ...]


class Run:
    """`frontage run` as a process, whose descendants can be found."""

    def __init__(self, project: Path, out: Path, workers: int) -> None:
        self.mark = uuid.uuid4().hex
        paths = os.pathsep.join(p for p in sys.path if p)
        command = [sys.executable, "-m", "frontage", "run", str(project), "-o", str(out), "--quiet"]
        self.process = subprocess.Popen(
            [*command, "--workers", str(workers)],
            env={**os.environ, "PYTHONPATH": paths, _MARK: self.mark},
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        )  # fmt: skip
        self.session = self.process.pid

    def wait(self, seconds: float | None = None) -> tuple[int, str]:
        """The exit code and what was written to standard error."""
        _, said = self.process.communicate(timeout=seconds)
        return self.process.returncode, said

    def kill(self) -> None:
        """SIGKILL to the parent alone: its workers are not told."""
        self.process.kill()
        self.process.wait()

    def alive(self) -> tuple[str, ...]:
        """The command lines of living processes of this run."""
        return tuple(_told(pid) for pid in _processes() if self._owns(pid))

    def used(self) -> dict[int, float]:
        """The processor time in s of every living process of this run."""
        return {pid: _processor_time(pid) for pid in _processes() if self._owns(pid)}

    def _owns(self, pid: int) -> bool:
        try:
            state, *_ = fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
            if state in "ZX":
                return False
            marked = f"{_MARK}={self.mark}".encode()
            return int(fields[3]) == self.session or marked in Path(f"/proc/{pid}/environ").read_bytes()
        except (OSError, IndexError):
            return False

    def orphans(self) -> tuple[str, ...]:
        """The processes that work on or hang; returns at once when none is left.

        Work is told by processor time, because on a busy machine a process that is ending lives for seconds.
        """
        before, end = self.used(), time.monotonic() + HANGS_S
        while left := self.used():
            busy = [pid for pid, used in left.items() if used - before.get(pid, 0.0) > WORKS_ON_S]
            if busy or time.monotonic() > end:
                return tuple(_told(pid) for pid in busy or left)
            time.sleep(0.05)
        return ()

    def clean(self) -> None:
        """End what is left of the run, and nothing else."""
        for pid in _processes():
            if self._owns(pid):
                with suppress(OSError):
                    os.kill(pid, signal.SIGKILL)
        if self.process.stderr is not None:
            self.process.stderr.close()


def _processes() -> list[int]:
    return [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]


def _processor_time(pid: int) -> float:
    """Of the process itself in s; 0 when it has just ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _told(pid: int) -> str:
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")[:120]
    return str(pid)


def contents(out: Path) -> dict[str, str]:
    """The hash of every result; without markers, the lock, and the timings of the manifest."""
    files = (p for p in sorted(out.rglob("*")) if p.is_file())
    return {
        str(p.relative_to(out)): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in files
        if ".done" not in p.relative_to(out).parts and p.name not in _UNEQUAL
    }


def markers(out: Path) -> int:
    """How many stages and items are finished."""
    return len(list((out / ".done").glob("*.json")))


def unkilled(project: Path, out: Path, workers: int) -> Whole:
    """A run, or the rest of one, that is left alone. Raises RuntimeError when it fails."""
    start, run = time.monotonic(), Run(project, out, workers)
    try:
        code, said = run.wait()
    finally:
        run.clean()
    if code != 0:
        raise RuntimeError(f"the run failed without a kill: {said}")
    return Whole(contents(out), time.monotonic() - start, markers(out))


def moments(count: int, seed: int) -> list[float]:
    """Shares of a run: one at random in each of `count` equal parts, in random order."""
    r = random.Random(seed)
    shares = [(part + r.random()) / count for part in range(count)]
    r.shuffle(shares)
    return shares


def kill_at(project: Path, out: Path, workers: int, share: float, whole: Whole) -> Kill:
    """Start or resume a run and kill it when it has finished this share, unless it ends before.

    The share counts markers, because the speed of a busy machine changes; the rest of it, less than the step
    from one marker to the next, is a share of the mean time of such a step.
    """
    steps = int(share * whole.markers)
    pause = (share * whole.markers - steps) * whole.seconds / whole.markers
    run = Run(project, out, workers)
    try:
        while markers(out) < steps and run.process.poll() is None:
            time.sleep(0.005)
        with suppress(subprocess.TimeoutExpired):
            run.process.wait(pause)
        run.kill()
        return Kill(markers(out), run.orphans())
    finally:
        run.clean()


def killed_often(
    project: Path, folder: Path, whole: Whole, workers: int, count: int, seed: int
) -> list[Kill]:
    """Kill `count` runs; every folder is resumed and killed three times before its run may end.

    `whole`: the run that was left alone. Raises AssertionError when the results differ from those.
    """
    kills: list[Kill] = []
    shares = moments(count, seed)
    for number in range(0, count, 3):
        out = folder / f"killed{workers}_{number}"
        kills += [
            kill_at(project, out, workers, share, whole) for share in sorted(shares[number : number + 3])
        ]
        again, expected = unkilled(project, out, workers).contents, whole.contents
        differ = sorted(n for n in expected.keys() | again.keys() if expected.get(n) != again.get(n))
        assert not differ, f"after kills the results differ: {differ[:5]}"
    return kills


def main() -> int:
    """Kill runs with one and with two workers; 1 if a process outlived its run or a result differs."""
    parser = argparse.ArgumentParser(prog="python -m fuzz.kills", description=__doc__)
    parser.add_argument("--kills", type=int, default=30, help="how many, half of them with two workers")
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="frontage-kills-") as temporary:
        project = small_street(Path(temporary))
        whole = unkilled(project, Path(temporary) / "whole", 1)
        orphans = 0
        for workers in (1, 2):
            kills = killed_often(
                project, Path(temporary), whole, workers, given.kills // 2, given.seed + workers
            )
            left = [kill for kill in kills if kill.orphans]
            orphans += len(left)
            done = ", ".join(str(kill.markers) for kill in sorted(kills, key=lambda kill: kill.markers))
            print(f"{workers} workers: {len(kills)} kills, results equal, {len(left)} left processes behind")
            print(f"    after {done} of {whole.markers} markers", flush=True)
            for kill in left:
                print(f"    still alive: {', '.join(kill.orphans)}")
    return int(orphans > 0)


def small_street(folder: Path) -> Path:
    """The project file of a small simulated scene of two houses."""
    from frontage.simulate.spec import parse_spec
    from frontage.studies.simulate import simulate
    from simulated import BARE

    return simulate(parse_spec(BARE.replace("houses = 1", "houses = 2")), folder / "scene").project


if __name__ == "__main__":
    sys.exit(main())
