"""`frontage pixel-to-world`."""

import json
from dataclasses import asdict
from pathlib import Path

import click


@click.command("pixel-to-world", context_settings={"ignore_unknown_options": True})
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.argument("facade")
@click.argument("column", type=float, metavar="COL")
@click.argument("row", type=float)
@click.option("--plane", is_flag=True, help="On the plane, even where relief was measured.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def command(out: Path, facade: str, column: float, row: float, plane: bool, as_json: bool) -> None:
    """World position of pixel (COL, ROW) of a FACADE ("B07/F1"): X Y Z in metres, and relief or plane.

    The centre of the first pixel is at 0.5 0.5.
    """
    from frontage.queries.runfolder import open_run

    pixels = open_run(out).facade(facade)
    point = pixels.pixel_to_world(column, row, relief=not plane)
    if as_json:
        click.echo(json.dumps({**asdict(point), "crs": pixels.crs}))
    else:
        click.echo(f"{point.x:z.4f} {point.y:z.4f} {point.z:z.4f} {point.surface}")
