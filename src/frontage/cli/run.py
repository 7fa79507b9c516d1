"""`frontage run`: the whole chain."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frontage.cli.console import (
    BAR_METHODS,
    common,
    method_option,
    progress,
    strict_option,
    tell,
    workers_option,
)

if TYPE_CHECKING:
    from frontage.pipeline.project import Project


@click.command("run")
@click.argument("project", required=False, type=click.Path(path_type=Path), metavar="[PROJECT.toml]")
@click.option("--scan", "scans", multiple=True, help="Scan file or glob; may be given again.")
@click.option("--scan-crs", help="CRS of the scans, where the files do not say it.")
@click.option(
    "--units", type=click.Choice(["m", "cm", "mm", "ft", "us-ft"]), help="Unit of the scans' coordinates."
)
@click.option("--trajectory", help="Trajectory of a mobile scan (CSV or SBET).")
@click.option("--stations", help="JSON of station positions of a LAS scan.")
@click.option(
    "--pose",
    type=click.Choice(["trusted", "approximate"]),
    help="Of the scans; approximate ones (GPS, compass) are registered to --model.",
)
@click.option("--photos", help="Folder or glob of photos.")
@click.option(
    "--cameras",
    help="The photos' cameras and poses: a COLMAP folder, or a file of Metashape, OpenSfM, Pix4D or "
    "RealityScan; without --scan the points of a COLMAP folder are the cloud.",
)
@click.option(
    "--photo-pose",
    type=click.Choice(["trusted", "approximate", "none"]),
    help="Of the photos; those that are not trusted are oriented against the scans.",
)
@click.option("--photo-offset", nargs=3, type=float, metavar="X Y Z", help="Added to camera positions, m.")
@click.option("--model", "city_model", help="City model or footprints (CityJSON, CityGML, GeoJSON, GPKG).")
@click.option("--crs", help="CRS of the result; default: the scans' own.")
@click.option("--gsd", type=float, help="Metres per pixel of the ortho-images.")
@method_option
@click.option(
    "--bars",
    type=click.Choice(BAR_METHODS),
    help="How window bars are found; none: windows have no bars; default: the project's, evidence.",
)
@click.option("--seed", type=int, help="Seed of every random choice.")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Run folder; default: the project's name.")
@click.option(
    "--verify", is_flag=True, help="Compare the checksums of finished results, and make damaged ones again."
)
@strict_option
@workers_option
@common
def command(
    project: Path | None,
    out: Path | None,
    verify: bool,
    strict: bool,
    workers: int,
    quiet: bool,
    as_json: bool,
    **flags: Any,
) -> None:
    """The whole chain: scans and photos to ortho-images, model and report.

    Give a PROJECT.toml, or flags instead of a file. A run that was stopped goes on where it was.
    """
    from frontage.pipeline.run import run

    if (project is None) == (not any(flags[name] for name in ("scans", "cameras"))):
        raise click.UsageError("give either a PROJECT.toml or --scan (or --photos with --cameras)")
    if project is None and out is None:
        raise click.UsageError("name the run folder with -o OUT")
    made = _from_flags(flags) if project is None else _from_file(project, flags)
    folder = out or Path(project.stem + "_out" if project else "out")
    summary = run(made, folder, workers=workers, progress=progress(quiet, as_json), verify=verify)
    tell(summary, quiet, as_json, strict)


def _from_flags(flags: dict[str, Any]) -> "Project":
    """A project from the flags, with paths relative to the current folder."""
    from frontage.pipeline.project import make_project

    names = ("units", "trajectory", "stations", "pose")
    scan = _given(flags, crs="scan_crs", **{name: name for name in names})
    table: dict[str, Any] = {
        "project": _given(flags, crs="crs", seed="seed"),
        "scans": [{"path": path, **scan} for path in flags["scans"]],
        "ortho": _given(flags, gsd="gsd"),
        "openings": _given(flags, method="method"),
        "crossbars": _given(flags, method="bars"),
    }
    photos = _given(flags, path="photos", cameras="cameras", offset="photo_offset", pose="photo_pose")
    if photos:
        table["photos"] = photos
    if flags["city_model"]:
        table["model"] = {"path": flags["city_model"]}
    return make_project(table, Path.cwd(), "the command line")


def _from_file(path: Path, flags: dict[str, Any]) -> "Project":
    """A project file; flags of options replace what it says, those of inputs belong in it."""
    from frontage.pipeline.project import load_project

    changes = {
        "project": _given(flags, crs="crs", seed="seed"),
        "ortho": _given(flags, gsd="gsd"),
        "openings": _given(flags, method="method"),
        "crossbars": _given(flags, method="bars"),
    }
    used = {"crs", "seed", "gsd", "method", "bars"}
    extra = [name for name, value in flags.items() if value and name not in used]
    if extra:
        raise click.UsageError(f"with a project file, --{extra[0].replace('_', '-')} belongs into the file")
    return load_project(path, changes)


def _given(flags: dict[str, Any], **names: str) -> dict[str, Any]:
    """The flags that were given, under the names of the project file."""
    return {key: flags[name] for key, name in names.items() if flags[name] not in (None, (), "")}
