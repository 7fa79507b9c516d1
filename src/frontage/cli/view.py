"""`frontage view`."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frontage.cli.console import common
from frontage.errors import printable

if TYPE_CHECKING:
    from frontage.viewer.site import Site


@click.command("view")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.option(
    "--export",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write a static site into DIR instead; any web server can serve it, without a network.",
)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Of this machine; default: any free one."
)
@click.option("--open", "open_browser", is_flag=True, help="Open the browser.")
@common
def command(
    out: Path, folder: Path | None, port: int, open_browser: bool, quiet: bool, as_json: bool
) -> None:  # fmt: skip
    """Look at the run folder OUT in a browser: the street in 3-D, facades to measure on, openings, photos.

    It is served to this machine alone, until Ctrl-C.
    """
    from frontage.pipeline.store.store import Store
    from frontage.viewer.site import site_of

    site = site_of(Store(out))
    if folder is not None:
        _export(site, folder, quiet, as_json)
    else:
        _serve(site, port, open_browser, quiet, as_json)


def _export(site: "Site", folder: Path, quiet: bool, as_json: bool) -> None:
    from frontage.viewer.export import export

    made = export(site, folder)
    if as_json:
        table = {"folder": str(folder), "files": made.files, "bytes": made.size, "failed": list(made.failed)}
        click.echo(json.dumps(table, ensure_ascii=False))
        return
    for reason in made.failed:
        click.echo(printable(f"warning: left out: {reason}"), err=True)
    if not quiet:
        click.echo(printable(f"{made.files} files, {made.size / 1e6:.1f} MB in {folder}"))


def _serve(site: "Site", port: int, open_browser: bool, quiet: bool, as_json: bool) -> None:
    from frontage.viewer.server import SiteServer

    with SiteServer(site, port) as server:
        if as_json:
            click.echo(json.dumps({"address": server.address}))
        elif not quiet:
            click.echo(f"{server.address} (Ctrl-C ends it)")
        if open_browser:
            click.launch(server.address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            return
