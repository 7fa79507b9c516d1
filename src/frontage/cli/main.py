"""The command `frontage`: a group that imports a command's file only when that command is called.

Exit codes: 0 done, 1 failed (one sentence on stderr), 2 wrong usage, 130 interrupted.
"""

import importlib
import logging
import os
import signal
import sys
from contextlib import suppress
from difflib import get_close_matches
from typing import Any

import click

from frontage import __version__
from frontage.errors import FrontageError, printable

# Each command with its line in --help, so that help imports nothing; it lives in the module of its name.
COMMANDS = {
    "demo": "Simulate a small street, run the whole chain on it, and score the result.",
    "run": "The whole chain: scans and photos to ortho-images, model and report.",
    "info": "What is in a scan, a photo folder's cameras, or a run folder.",
    "register": "Register the approximate scans of a run folder to its city model again.",
    "orient": "Orient the free photos of a run folder against its scans again.",
    "buildings": "Split the street of a run folder into buildings again.",
    "facades": "Find the facades of a run folder's buildings again.",
    "ortho": "Make the ortho-images of a run folder again.",
    "openings": "Find the windows, doors and protrusions of a run folder's facades again.",
    "crossbars": "Find the bars in the windows of a run folder's facades again.",
    "model": "Build the LoD3 model (CityJSON, CityGML, GLB) of a run folder again.",
    "export": "Write the textured facades (GLB, OBJ), tables, drawings and the IFC model again.",
    "report": "Write report.html of a run folder again.",
    "view": "Look at a run folder in a browser, or write it as a static site.",
    "locate": "Where an opening is: by address, floor and number, or by its id.",
    "pixel-to-world": "World position of an ortho-image pixel.",
    "world-to-pixel": "Ortho-image pixel of a world position.",
    "validate": "Check solids against ISO 19107, with val3dity's error codes.",
    "simulate": "A street with exact truth: scans, photos, city model.",
    "score": "A run folder against the truth of its simulated scene.",
}


class LazyGroup(click.Group):
    """Lists its commands from `COMMANDS`, imports one when it is called, and turns errors into sentences."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of work."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the module of the command and return its `command`."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"frontage.cli.{cmd_name.replace('-', '_')}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command, or fail with the names that are nearly the same."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            near = get_close_matches(args[0], COMMANDS, n=3)
            if not near:
                raise
            guess = " or ".join(repr(name) for name in near)
            raise click.UsageError(f"{error.message} Did you mean {guess}?", ctx) from None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The list of commands, without importing one."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run the command line and exit; no traceback reaches the user unless -v asks for it."""
        kwargs["standalone_mode"] = False
        interrupted = _interruptions()
        try:
            code = super().main(*args, **kwargs)
        except click.ClickException as error:
            error.show()
            code = error.exit_code
        except (KeyboardInterrupt, click.Abort):
            code = _interrupt()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            code = 1
        except Exception as error:  # compiled libraries turn an interruption into an error of their own
            code = _interrupt() if interrupted else _failure(error)
        sys.exit(code if isinstance(code, int) else 0)


def _interruptions() -> list[int]:
    """Returns the list to which Ctrl-C and SIGTERM, which end a run alike, add their numbers from now on."""
    numbers: list[int] = []

    def interrupt(number: int, frame: object) -> None:
        numbers.append(number)
        raise KeyboardInterrupt

    with suppress(ValueError):  # handlers can only be set in the main thread
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not signal.SIG_IGN:  # as in the background of a shell
                signal.signal(number, interrupt)
    return numbers


def _interrupt() -> int:
    """Says that the run was interrupted; returns the exit code."""
    click.echo("interrupted; the same command goes on where it was", err=True)
    return 130


def _failure(error: Exception) -> int:
    """Says what went wrong; returns the exit code.

    An error that nobody foresaw is told in one sentence, or with its traceback with -v.
    """
    if isinstance(error, FrontageError):
        click.echo(f"frontage: {error} [{error.code}]", err=True)
        return 1
    if logging.getLogger("frontage").isEnabledFor(logging.INFO):
        import traceback

        traceback.print_exception(error)
    text = printable(" ".join(str(error).split())[:200])
    click.echo(
        f"frontage: unexpected {type(error).__name__}: {text}; a bug: run with -v and report it", err=True
    )
    return 1


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="frontage")
def main() -> None:
    """Measured facades from laser scans and photographs of a street."""
    # BLAS sums in another order with other thread counts; one thread = the same bytes at any --workers.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")


if __name__ == "__main__":
    main()
