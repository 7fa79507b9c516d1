"""`frontage score`."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from frontage.evaluation.metric import Metric
    from frontage.studies.score import Scores

_SENSORS = ("stations", "drive", "photos")


@click.command("score")
@click.argument("run", type=click.Path(path_type=Path), metavar="RUN")
@click.argument("truth", type=click.Path(path_type=Path), metavar="TRUTH")
@click.option(
    "--require",
    "bounds",
    multiple=True,
    metavar="BOUND",
    help='A bound such as "openings.f1_50>=0.9"; exit code 1 when it is not kept. May be given again.',
)
@click.option(
    "--sensor",
    "sensors",
    multiple=True,
    type=click.Choice(_SENSORS),
    help="What the run had, to tell visible from hidden; default: everything of the scene.",
)
@click.option("--json", "as_json", is_flag=True, help="Print all figures and items as JSON on stdout.")
def command(run: Path, truth: Path, bounds: tuple[str, ...], sensors: tuple[str, ...], as_json: bool) -> None:
    """Score a run folder (RUN) against the truth of the simulated scene (TRUTH) it was made from.

    TRUTH is the folder that `frontage simulate` wrote. Every figure has its 95 % interval and the number of
    items behind it. The exit code is 0 however poor the figures are, unless a --require bound is broken.
    """
    from frontage.studies.score import parse_gate, score

    gates = [parse_gate(bound) for bound in bounds]
    scores = score(run, truth, sensors)
    kept = [gate.holds(scores) for gate in gates]
    if as_json:
        table = scores.table()
        table["bounds"] = [{"bound": str(g), "kept": k} for g, (k, _) in zip(gates, kept, strict=True)]
        click.echo(json.dumps(table, indent=1, ensure_ascii=False))
    else:
        show(scores)
    for holds, sentence in kept:
        if not holds:
            click.echo(f"not kept: {sentence}", err=True)
    if not all(holds for holds, _ in kept):
        raise click.exceptions.Exit(1)


def show(scores: "Scores") -> None:
    """All figures as a table on stdout; what is absent says so."""
    from frontage.evaluation.metric import Absent

    for name, part in scores.parts.items():
        if isinstance(part, Absent):
            click.echo(f"{name:<10} absent: {part.reason}")
            continue
        click.echo(name)
        for key, figure in part.figures.items():
            if figure.value is not None:
                click.echo(f"  {key:<24} {line(figure)}")
        for note in part.notes:
            click.echo(f"  note: {note}")


def line(figure: "Metric") -> str:
    """A figure as `value unit  [low, high]  n`; lengths below a metre in millimetres."""
    assert figure.value is not None
    small = figure.unit == "m" and abs(figure.value) < 1.0
    factor, unit = (1000.0, "mm") if small else (1.0, figure.unit)

    def number(value: float) -> str:
        return f"{value * factor:.4g}"

    head = f"{number(figure.value):>8} {unit:<4}"
    if figure.low is None or figure.high is None:
        return head.rstrip()
    return f"{head} [{number(figure.low)}, {number(figure.high)}]  n = {figure.n}"
