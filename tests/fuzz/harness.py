"""Runs cases: makes a damaged file, has a worker process read it, and judges what came of it.

A case is named by its seed file, the seed of the random numbers and its number, so that it can be repeated::

    python -m fuzz --only "PLY ascii" --case 17 --seed 5
"""

import json
import os
import random
import select
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from fuzz.mutations import flip, mutations
from fuzz.runseeds import folder_seeds, run_seeds, small_run
from fuzz.seeds import SEEDS, Seed
from fuzz.worker import MEMORY_MB, SECONDS

LONGEST_SENTENCE = 600  # characters
_STARTING_S = 120.0  # at most, for the imports of a worker on a busy machine
_BLAMES = (
    "MemoryError", "Unable to allocate", "bad_alloc", "bad alloc", "cannot allocate memory", "std::",
    "Insufficient memory", "maximum recursion", "Traceback", "object at 0x", "alloc.cpp",
)  # fmt: skip
"""What no sentence for a user says: the inner troubles of the program."""


SPECIAL: dict[str, Callable[[Path], object]] = {
    "empty": Path.touch,
    "folder": Path.mkdir,
    "dangling": lambda path: path.symlink_to("nowhere"),
    "loop": lambda path: path.symlink_to(path.name),
    "fifo": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
}
"""What can stand in the place of a file, by its name."""
_OUTSIDE = ("fifo", "device")  # only for files that users bring, not for those of a run folder


@dataclass(frozen=True)
class Case:
    """A mutation of a seed file; `special`: something else in its place."""

    seed: Seed
    number: int
    random_seed: int
    special: str = ""

    @property
    def name(self) -> str:
        return f"{self.seed.name} / seed {self.random_seed} / case {self.number}"

    @property
    def again(self) -> str:
        """The command that repeats it."""
        chosen = (
            f"--special {self.special}" if self.special else f"--seed {self.random_seed} --case {self.number}"
        )
        return f"python -m fuzz --only {self.seed.name!r} {chosen}"

    def damage(self, path: Path, whole: bytes) -> str:
        """Put the case in the place of the whole file; returns the name of the mutation."""
        path.unlink()
        if self.special:
            SPECIAL[self.special](path)
            return self.special
        mutation, data = self.data(whole)
        path.write_bytes(data)
        return mutation

    def data(self, whole: bytes) -> tuple[str, bytes]:
        """The name of the mutation, and what it makes of the bytes of the whole file."""
        r = random.Random(f"{self.random_seed}/{self.seed.name}/{self.number}")
        mutation = r.choice(mutations(self.seed.kinds))
        try:
            return mutation.__name__, mutation(r, whole) or b" "
        except (ValueError, LookupError, SyntaxError, struct.error):
            return flip.__name__, flip(r, whole)  # a file of `folder_seeds` that is not well-formed itself


@dataclass(frozen=True)
class Result:
    """What came of a case: "read", "refused", or what is wrong; with the worst time and memory."""

    case: Case
    mutation: str
    outcome: str
    message: str
    seconds: float
    mb: int

    @property
    def failed(self) -> bool:
        return self.outcome not in ("read", "refused")


class Worker:
    """A process that reads files under limits; it is started anew when it has died."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def read(self, reader: str, path: Path) -> dict[str, Any]:
        """The answer of the worker; the outcome is "signal" when it died, "hang" without an answer."""
        fresh = self._process is None
        process = self._process or self._started()
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(json.dumps({"reader": reader, "path": str(path)}) + "\n")
        process.stdin.flush()
        limit = 2.0 * SECONDS + (_STARTING_S if fresh else 0.0)
        ready, _, _ = select.select([process.stdout], [], [], limit)
        line = process.stdout.readline() if ready else ""
        if line:
            answer: dict[str, Any] = json.loads(line)
            return answer
        outcome = "signal" if ready else "hang"
        status = self._end()
        return {"outcome": outcome, "message": f"the process ended with {status}", "seconds": limit, "mb": 0}

    def _started(self) -> subprocess.Popen[str]:
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        paths = os.pathsep.join(p for p in sys.path if p)
        environment = {**os.environ, **threads, "PYTHONPATH": paths}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "fuzz.worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True, env=environment,
        )  # fmt: skip
        return self._process

    def _end(self) -> int | None:
        process, self._process = self._process, None
        if process is None:
            return None
        try:
            status = process.wait(0.5) if process.poll() is None else process.returncode
        except subprocess.TimeoutExpired:
            process.kill()
            status = process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()
        return status


def judged(answer: dict[str, Any], folder: Path) -> tuple[str, str]:
    """The outcome of a case: a refusal must be one sentence that names a file; limits must be kept."""
    outcome, message = answer["outcome"], answer["message"]
    if outcome in ("signal", "hang", "error", "nonsense"):
        return outcome, message
    if answer["seconds"] > SECONDS:
        return "slow", f"{answer['seconds']:.1f} s; {message}"
    if answer["mb"] > MEMORY_MB:
        return "memory", f"{answer['mb']} MB; {message}"
    if outcome == "refused" and (fault := unclear(message, folder)):
        return "unclear", f"{fault}: {message[:400]!r}"
    return outcome, message


def unclear(message: str, folder: Path) -> str:
    """Why a message is no clear sentence; "" when it is one."""
    names = {path.name for path in folder.rglob("*")}
    if "\n" in message or not message.isprintable():
        return "more than one line, or control characters"
    if not 15 <= len(message) <= LONGEST_SENTENCE:
        return f"{len(message)} characters"
    if str(folder) not in message and not any(name in message for name in names):
        return "no file is named"
    blamed = next((words for words in _BLAMES if words in message), None)
    return f"tells of {blamed!r}" if blamed else ""


def cases(seeds: Sequence[Seed], count: int, random_seed: int) -> Iterator[Case]:
    """`count` cases, in turn from every seed file."""
    for k in range(count):
        yield Case(seeds[k % len(seeds)], k // len(seeds), random_seed)


def special_cases(seeds: Sequence[Seed]) -> Iterator[Case]:
    """Every seed file replaced by a folder, a pipe, a device, ..."""
    for seed in seeds:
        for name in SPECIAL:
            if seed.reader != "run" or name not in _OUTSIDE:
                yield Case(seed, -1, 0, name)


class Harness:
    """Reads cases in one worker.

    keep   folder for the files that failed, outside the repository
    files  folder whose small files are the seeds, in place of those of `seeds`
    """

    def __init__(self, folder: Path, keep: Path | None = None, files: Path | None = None) -> None:
        self._folder = folder
        self._keep = keep
        self._made: dict[str, tuple[Path, bytes]] = {}
        self._worker = Worker()
        self.seeds = folder_seeds(files) if files else (*SEEDS, *run_seeds(small_run(folder / "small")))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._worker.__exit__(kind, error, trace)

    def whole(self, seed: Seed) -> tuple[Path, bytes]:
        """The file of a seed that is mutated, and its undamaged bytes."""
        if seed.name not in self._made:
            folder = self._folder / seed.name.replace("/", "_").replace(" ", "_")
            folder.mkdir(parents=True)
            path = seed.make(folder)
            self._made[seed.name] = path, path.read_bytes()
        return self._made[seed.name]

    def undamaged(self, seed: Seed) -> tuple[str, str]:
        """The outcome of a seed itself: it must be read."""
        path, data = self.whole(seed)
        path.write_bytes(data)
        return judged(self._worker.read(seed.reader, path), self._top(path))

    def run(self, case: Case) -> Result:
        """Make, read and judge one case."""
        path, whole = self.whole(case.seed)
        mutation = case.damage(path, whole)
        answer = self._worker.read(case.seed.reader, path)
        outcome, message = judged(answer, self._top(path))
        result = Result(case, mutation, outcome, message, answer["seconds"], answer["mb"])
        if result.failed and self._keep is not None:
            self._save(result, path)
        if path.is_dir():
            path.rmdir()
        else:
            path.unlink()
        path.write_bytes(whole)
        return result

    def _top(self, path: Path) -> Path:
        return next(p for p in (path, *path.parents) if p.parent == self._folder)

    def _save(self, result: Result, path: Path) -> None:
        assert self._keep is not None
        folder = self._keep / f"{self._top(path).name}_{result.case.special or result.case.number}"
        folder.mkdir(parents=True, exist_ok=True)
        if not result.case.special:
            shutil.copyfile(path, folder / path.name)
        (folder / "result.txt").write_text(
            f"{result.case.name}\n{result.mutation}\n{result.outcome}: {result.message}\n", "utf-8"
        )


def temporary() -> tempfile.TemporaryDirectory[str]:
    """A folder for the files of a run of the harness."""
    return tempfile.TemporaryDirectory(prefix="frontage-fuzz-")
