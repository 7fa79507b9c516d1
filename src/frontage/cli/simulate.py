"""`frontage simulate`."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from frontage.cli.console import common, progress, workers_option


@click.command("simulate")
@click.argument("spec", required=False, type=click.Path(path_type=Path), metavar="[SPEC.toml]")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the scene; needs no SPEC.toml.")
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="Folder of the scene.")
@workers_option
@common
def command(spec: Path | None, seed: int | None, out: Path, workers: int, quiet: bool, as_json: bool) -> None:
    """Simulate a street with exact truth: scans, photos, an LoD2 model, and a project that reads them.

    What SPEC.toml leaves out is drawn from the seed; with --seed alone everything is. The keys are in
    docs/reference/simulate.md.
    """
    from frontage.io.files import text_of
    from frontage.simulate.spec import SceneSpec, parse_spec
    from frontage.studies.simulate import simulate

    if spec is None and seed is None:
        raise click.UsageError("give a SPEC.toml or a --seed")
    made = SceneSpec()
    if spec is not None:
        made = parse_spec(text_of(spec, "give the path of a SPEC.toml"), str(spec))
    if seed is not None:
        made = made.model_copy(update={"seed": seed})
    base = spec.parent if spec is not None else Path(".")
    done = simulate(made, out, base=base, workers=workers, progress=progress(quiet, as_json))
    if as_json:
        click.echo(json.dumps(asdict(done), indent=1, default=str))
        return
    if quiet:
        return
    for note in done.notes:
        click.echo(f"note: {note}", err=True)
    click.echo(
        f"{done.points:,} points of {done.scans} scans and {done.photos} photos of {done.facades} facades"
    )
    click.echo(f"next: frontage run {out / 'project.toml'} -o RUN; frontage score RUN {out}")
