"""`frontage crossbars`."""

from pathlib import Path

import click

from frontage.cli.console import BAR_METHODS, common, progress, strict_option, tell, workers_option


@click.command("crossbars")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.option(
    "--method", type=click.Choice(BAR_METHODS), help="How bars are found; none: windows have no bars."
)
@strict_option
@workers_option
@common
def command(out: Path, method: str | None, strict: bool, workers: int, quiet: bool, as_json: bool) -> None:
    """Find the bars in the windows of a run folder's facades again."""
    from frontage.pipeline.run import run_stage

    options = {} if method is None else {"method": method}
    shown = progress(quiet, as_json)
    tell(
        run_stage(out, "crossbars", options=options, workers=workers, progress=shown), quiet, as_json, strict
    )
