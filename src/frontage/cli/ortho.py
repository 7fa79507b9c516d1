"""`frontage ortho`."""

from pathlib import Path

import click

from frontage.cli.console import common, progress, strict_option, tell, workers_option


@click.command("ortho")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.option("--gsd", type=float, help="Metres per pixel, in place of the run's.")
@strict_option
@workers_option
@common
def command(out: Path, gsd: float | None, strict: bool, workers: int, quiet: bool, as_json: bool) -> None:
    """Make the ortho-images of a run folder again."""
    from frontage.pipeline.run import run_stage

    options = {} if gsd is None else {"gsd": gsd}
    bars = progress(quiet, as_json)
    tell(run_stage(out, "ortho", options=options, workers=workers, progress=bars), quiet, as_json, strict)
