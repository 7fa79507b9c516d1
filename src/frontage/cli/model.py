"""`frontage model`."""

from pathlib import Path

import click

from frontage.cli.console import common, progress, strict_option, tell, workers_option


@click.command("model")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.option("--reseat/--keep-walls", default=None, help="Move the host's walls onto the measured planes.")
@click.option("--depth/--flush", default=None, help="Openings at their depth, or flush and no protrusions.")
@click.option("--max-offset", type=float, help="Metres between the measured planes and the host's walls.")
@strict_option
@workers_option
@common
def command(
    out: Path,
    reseat: bool | None,
    depth: bool | None,
    max_offset: float | None,
    strict: bool,
    workers: int,
    quiet: bool,
    as_json: bool,
) -> None:
    """Build the LoD3 model of a run folder again: CityJSON, CityGML 2.0 and 3.0, GLB, pictures."""
    from frontage.pipeline.run import run_stage

    given = {"reseat": reseat, "depth": depth, "max_offset": max_offset}
    options = {name: value for name, value in given.items() if value is not None}
    bars = progress(quiet, as_json)
    tell(run_stage(out, "model", options=options, workers=workers, progress=bars), quiet, as_json, strict)
