"""`frontage openings`."""

from pathlib import Path

import click

from frontage.cli.console import common, method_option, progress, strict_option, tell, workers_option


@click.command("openings")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@method_option
@strict_option
@workers_option
@common
def command(out: Path, method: str | None, strict: bool, workers: int, quiet: bool, as_json: bool) -> None:
    """Find the windows, doors and protrusions of a run folder's facades again."""
    from frontage.pipeline.run import run_stage

    options = {} if method is None else {"method": method}
    bars = progress(quiet, as_json)
    tell(run_stage(out, "openings", options=options, workers=workers, progress=bars), quiet, as_json, strict)
