"""What the benchmarks share: simulated scenes, confidence intervals, fair timing, tables, and `--write`.

Every figure is printed with its interval: a median or rate over cases with a bootstrap, a time or a ratio of
times over alternating repetitions.

Every benchmark takes ``--write PAGE.md``: what it prints then also becomes a section of that page,
in place of the section of an earlier run of the same script.
"""

import atexit
import io
import re
import shlex
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
sys.path.insert(0, str(ROOT / "tests"))  # scenes that benchmarks and tests share

Statistic = Callable[[np.ndarray], float]


class Tee(io.TextIOBase):
    """Writes to a stream and remembers what was written."""

    def __init__(self, stream: Any) -> None:
        self.stream, self.parts = stream, [""]

    def write(self, text: str) -> int:
        """Write to both."""
        self.parts.append(text)
        return int(self.stream.write(text))

    def flush(self) -> None:
        """Flush the stream."""
        self.stream.flush()


def write_section(page: Path, script: str, command: str, text: str) -> None:
    """Put the output of a benchmark on a page, in place of what the same script wrote there before.

    The section lies between two comments that name the script, so the rest of the page stays as it is.
    """
    start, end = f"<!-- begin {script} -->", f"<!-- end {script} -->"
    body = re.sub(r"^## ", "### ", text.strip(), flags=re.M)
    section = f"{start}\n\n## Output of {script}\n\n`{command}`\n\n{body}\n\n{end}"
    old = page.read_text("utf-8") if page.exists() else f"# Results of {script}\n"
    before, found, after = old.partition(start)
    new = before + section + after.partition(end)[2] if found else f"{old.rstrip()}\n\n{section}\n"
    page.write_text(new, "utf-8")


def _take_write_option(arguments: list[str]) -> None:
    """Remove `--write PAGE.md` from the arguments and arrange for the section to be written at the end."""
    if "--write" not in arguments[:-1]:
        return
    place = arguments.index("--write")
    page = Path(arguments[place + 1])
    del arguments[place : place + 2]
    script = Path(arguments[0]).name
    command = shlex.join(["python", f"benchmarks/{script}", *arguments[1:]])
    tee = Tee(sys.stdout)
    sys.stdout = tee
    atexit.register(lambda: write_section(page, script, command, "".join(tee.parts)))


_take_write_option(sys.argv)


def bootstrap(
    values: Sequence[float] | np.ndarray,
    statistic: Statistic = np.median,
    level: float = 0.95,
    draws: int = 2000,
    seed: int = 0,
) -> tuple[float, float, float]:
    """The statistic of the values and the ends of its percentile bootstrap interval (Efron 1979).

    Values are cases (scenes, facades), which are independent; never pass neighbouring pixels or points.
    """
    v = np.asarray(values, float)
    if len(v) == 0:
        raise ValueError("no values to take an interval of")
    rng = np.random.default_rng(seed)
    drawn = [statistic(v[rng.integers(0, len(v), len(v))]) for _ in range(draws)]
    low, high = np.quantile(drawn, [(1 - level) / 2, (1 + level) / 2])
    return float(statistic(v)), float(low), float(high)


def rate_interval(hits: int, total: int, z: float = 1.96) -> tuple[float, float, float]:
    """A share hits / total with its Wilson score interval, right near 0 and 1 too."""
    p = hits / total
    centre = (p + z * z / (2 * total)) / (1 + z * z / total)
    half = z / (1 + z * z / total) * np.sqrt(p * (1 - p) / total + z * z / (4 * total * total))
    return p, float(max(0.0, centre - half)), float(min(1.0, centre + half))


def seconds(work: Callable[[], Any], repeat: int = 5) -> tuple[float, float, float]:
    """Median wall time of `work` in seconds with its range, after one call that warms up."""
    work()
    times = [_once(work) for _ in range(repeat)]
    return float(np.median(times)), min(times), max(times)


def time_ratio(
    ours: Callable[[], Any], peer: Callable[[], Any], repeat: int = 7
) -> tuple[float, float, float]:
    """Median of (time of ours / time of the peer) with its bootstrap interval.

    The two alternate, so that whatever else the machine does slows both.
    """
    ours(), peer()
    ratios = [_once(ours) / _once(peer) for _ in range(repeat)]
    return bootstrap(ratios)


def _once(work: Callable[[], Any]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def peak_memory() -> float:
    """Largest resident size of this process so far, in GB (10^9 bytes); run each case in its own process."""
    import resource

    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size * (1 if sys.platform == "darwin" else 1024) / 1e9


def figure(value: tuple[float, float, float], unit: str = "", digits: int = 3) -> str:
    """`1.23 [1.10, 1.40] mm`."""
    middle, low, high = (f"{v:.{digits}g}" for v in value)
    return f"{middle} [{low}, {high}]" + (f" {unit}" if unit else "")


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Print a Markdown table under its title."""
    cells = [[str(c) for c in row] for row in (header, *rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    print(f"\n## {title}\n")
    for n, row in enumerate(cells):
        print("| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |")
        if n == 0:
            print("|" + "|".join("-" * (w + 2) for w in widths) + "|")


def timed_command(command: Sequence[str]) -> tuple[float, float]:
    """Wall seconds and peak memory in GB of a command and its children, run to its end.

    Raises RuntimeError with its last line when it fails.
    """
    import resource
    import subprocess

    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError((done.stderr or done.stdout).strip().splitlines()[-1])
    unit = 1 if sys.platform == "darwin" else 1024
    return time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * unit / 1e9
