"""`frontage buildings`."""

from pathlib import Path

import click

from frontage.cli.console import common, progress, tell, workers_option


@click.command("buildings")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@workers_option
@common
def command(out: Path, workers: int, quiet: bool, as_json: bool) -> None:
    """Split the street of a run folder into buildings again."""
    from frontage.pipeline.run import run_stage

    tell(run_stage(out, "buildings", workers=workers, progress=progress(quiet, as_json)), quiet, as_json)
