"""`frontage register`."""

from pathlib import Path

import click

from frontage.cli.console import common, progress, tell, workers_option


@click.command("register")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@workers_option
@common
def command(out: Path, workers: int, quiet: bool, as_json: bool) -> None:
    """Register the approximate scans of a run folder against its city model again."""
    from frontage.pipeline.run import run_stage

    tell(run_stage(out, "register", workers=workers, progress=progress(quiet, as_json)), quiet, as_json)
