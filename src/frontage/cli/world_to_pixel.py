"""`frontage world-to-pixel`."""

import json
from dataclasses import asdict
from pathlib import Path

import click


@click.command("world-to-pixel", context_settings={"ignore_unknown_options": True})
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.argument("facade")
@click.argument("x", type=float)
@click.argument("y", type=float)
@click.argument("z", type=float)
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def command(out: Path, facade: str, x: float, y: float, z: float, as_json: bool) -> None:
    """Pixel of the world position X Y Z (metres) in a FACADE's ortho-image: COL ROW, and its depth in metres.

    The depth is counted from the plane, positive into the building; "outside" = beyond the image's edges.
    """
    from frontage.queries.runfolder import open_run

    point = open_run(out).facade(facade).world_to_pixel(x, y, z)
    if as_json:
        click.echo(json.dumps(asdict(point)))
    else:
        where = "" if point.inside else " outside"
        click.echo(f"{point.column:z.4f} {point.row:z.4f} {point.depth:z.4f}{where}")
