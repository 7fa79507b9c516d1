"""What commands share: common options, progress bars, results for people and for machines."""

import json
import logging
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from frontage.errors import printable

if TYPE_CHECKING:
    from frontage.pipeline.progress import Progress
    from frontage.pipeline.run import Summary

Command = TypeVar("Command", bound=Callable[..., Any])

BAR_METHODS = ("evidence", "paper", "none")
"""The ways to find window bars, as in the project file."""


def common(command: Command) -> Command:
    """Add --json, --quiet and -v to a command; -v needs no parameter, the others do."""
    command = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON on stdout.")(
        command
    )
    command = click.option("--quiet", "-q", is_flag=True, help="Print nothing but warnings and errors.")(
        command
    )
    return click.option(
        "-v",
        "--verbose",
        count=True,
        expose_value=False,
        is_eager=True,
        callback=_log,
        help="Logs; -vv for more.",
    )(command)


def workers_option(command: Command) -> Command:
    """Add --workers."""
    kind = click.IntRange(1, 1024)
    text = "Processes; the result does not depend on it."
    return click.option("--workers", "-w", type=kind, default=1, show_default=True, help=text)(command)


def strict_option(command: Command) -> Command:
    """Add --strict."""
    text = "Exit with 1 if anything failed for a single building or facade."
    return click.option("--strict", is_flag=True, help=text)(command)


def stage_command(name: str, text: str) -> click.Command:
    """Make the command that runs one stage of a run folder again, without options of its own."""

    @click.command(name, help=text)
    @click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
    @strict_option
    @workers_option
    @common
    def command(out: Path, strict: bool, workers: int, quiet: bool, as_json: bool) -> None:
        from frontage.pipeline.run import run_stage

        summary = run_stage(out, name, workers=workers, progress=progress(quiet, as_json))
        tell(summary, quiet, as_json, strict)

    return command


def method_option(command: Command) -> Command:
    """Add --method, the way to find openings."""
    kind = click.Choice(["evidence", "paper"])
    text = "How openings are found; default: the run's, evidence."
    return click.option("--method", type=kind, help=text)(command)


def _log(ctx: click.Context, param: click.Parameter, value: int) -> None:
    """Logging to stderr: nothing, information, everything."""
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(value, 2)]
    logging.basicConfig(stream=sys.stderr, format="%(levelname)s %(name)s: %(message)s")
    logging.getLogger("frontage").setLevel(level)


def progress(quiet: bool, as_json: bool) -> "Progress":
    """Progress bars on stderr, or nobody told with --quiet and --json."""
    from frontage.pipeline.progress import Silent

    return Silent() if quiet or as_json else Bars()


class Bars:
    """One line per stage on stderr: what it made and how long it took; on a terminal a bar while it works."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        self._console = Console(stderr=True, highlight=False)
        columns = (
            TextColumn("{task.description:<10}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        self._bars = Progress(*columns, console=self._console, transient=True)
        self._task: Any = None
        self._start = time.perf_counter()

    def begin(self, stage: str, total: int) -> None:
        """Start a bar."""
        self._drop()
        if self._console.is_terminal:
            self._bars.start()
        self._task = self._bars.add_task(stage, total=total or None)

    def advance(self, stage: str) -> None:
        """One item further."""
        self._bars.advance(self._task)

    def end(self, stage: str, seconds: float, kept: bool, items: int) -> None:
        """Replace the bar by a line."""
        self._drop()
        if self._console.is_terminal:
            self._bars.stop()
        state = "kept" if kept else f"{seconds:.1f} s"
        self._console.print(f"{stage:<10} {items:>10,}  {state}", markup=False)

    def _drop(self) -> None:
        if self._task is not None:
            self._bars.remove_task(self._task)
            self._task = None


def tell(summary: "Summary", quiet: bool, as_json: bool, strict: bool = False) -> None:
    """Print the outcome of a run or a stage. Exits with 1 if `strict` and there are warnings."""
    if as_json:
        click.echo(json.dumps(as_table(summary), indent=1, ensure_ascii=False))
    else:
        _outcome(summary, quiet)
    if strict and summary.warnings:
        raise click.exceptions.Exit(1)


def _outcome(summary: "Summary", quiet: bool) -> None:
    for _, warning in summary.warnings:
        hint = f"; {warning.hint}" if warning.hint else ""
        click.echo(printable(f"warning {warning.code} {warning.item}: {warning.message}{hint}"), err=True)
    if quiet:
        return
    for note in summary.notes:
        click.echo(printable(f"note: {note}"), err=True)
    made = f"{len(summary.facades)} ortho-images"
    if "openings" in summary.items:
        made += f" and {summary.items['openings']} openings"
    click.echo(printable(f"{made} in {summary.out / 'facades'}; see {summary.out / 'report.html'}"))


def as_table(summary: "Summary") -> dict[str, Any]:
    """The summary, JSON-able."""
    return {
        "out": str(summary.out),
        "items": dict(summary.items),
        "facades": list(summary.facades),
        "warnings": [{"stage": stage, **asdict(warning)} for stage, warning in summary.warnings],
        "notes": list(summary.notes),
        "seconds": round(summary.seconds, 3),
    }
