"""`frontage demo`."""

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frontage.cli.console import as_table, common, progress

if TYPE_CHECKING:
    from frontage.studies.score import Scores

# What a reader wants to know first, in the order of the chain, with the name it is given.
_SHOWN = (
    ("buildings", "f1", "buildings, F1"),
    ("buildings", "cut_median", "cuts between neighbours, median error"),
    ("facades", "recall", "facades found"),
    ("facades", "offset_median", "facade planes, median offset"),
    ("facades", "angle_median", "facade planes, median angle"),
    ("ortho", "displacement_px_median", "ortho-images, median displacement"),
    ("openings", "f1_50", "openings, F1 at IoU 0.5"),
    ("openings", "f1_75", "openings, F1 at IoU 0.75"),
    ("openings", "border_median", "opening borders, median error"),
    ("openings", "depth_median", "opening depths, median error"),
    ("openings", "border_within_95", "opening borders, share within 95 % bounds"),
    ("openings", "depth_within_95", "opening depths, share within 95 % bounds"),
    ("openings", "bars_exact", "window bars, exact layouts"),
    ("model", "f1_50", "LoD3 model, F1 at IoU 0.5"),
)


@click.command("demo")
@click.argument("out", type=click.Path(path_type=Path), default="demo-out", metavar="[OUT]")
@click.option(
    "--workers",
    "-w",
    type=click.IntRange(min=1),
    default=min(2, os.cpu_count() or 1),
    show_default=True,
    help="Processes; the result does not depend on it.",
)
@common
def command(out: Path, workers: int, quiet: bool, as_json: bool) -> None:
    """Simulate a small street, run the whole chain on it, and score the result against the truth.

    OUT/street is the scene with its project and truth, OUT/result the run folder.
    """
    from frontage.studies.demo import demo

    done = demo(out, workers=workers, progress=progress(quiet, as_json))
    if as_json:
        table = {"run": as_table(done.run), "scores": done.scores.table()}
        click.echo(json.dumps(table, indent=1, ensure_ascii=False))
        return
    if quiet:
        return
    for note in done.scene.notes:
        click.echo(f"note: {note}", err=True)
    for _, warning in done.run.warnings:
        click.echo(f"warning {warning.code} {warning.item}: {warning.message}", err=True)
    show(done.scores)
    click.echo(f"all figures: frontage score {out / 'result'} {out / 'street'}")
    click.echo(f"the report: {(out / 'result' / 'report.html')}")


def show(scores: "Scores") -> None:
    """The figures that matter first, each with its 95 % interval."""
    from frontage.cli.score import line
    from frontage.evaluation.metric import Absent

    for part, key, name in _SHOWN:
        found = scores.parts[part]
        if not isinstance(found, Absent) and (figure := found.figures[key]).value is not None:
            click.echo(f"{name:<40} {line(figure)}")
