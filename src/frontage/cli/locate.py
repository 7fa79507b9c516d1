"""`frontage locate`."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from frontage.queries.answer import Located, Point

_CORNERS = ("lower left", "lower right", "upper right", "upper left")


@click.command("locate")
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.argument("address")
@click.option("--floor", "-f", type=int, help="Storey; the ground floor is 0, the basement -1.")
@click.option(
    "--window", "-w", type=click.IntRange(1), help="Its number on the floor, from the left as in ids."
)
@click.option("--door", "-d", type=click.IntRange(1), help="The same, of a door, gate or passage.")
@click.option("--facade", help='Facade of the building, "F2"; default: the one with the most openings.')
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def command(
    out: Path,
    address: str,
    floor: int | None,
    window: int | None,
    door: int | None,
    facade: str | None,
    as_json: bool,
) -> None:
    """Where an opening is in the world, how large, how sure, and which photos show it.

    ADDRESS is a building's address ("13 rue Soufflot") or id ("B07") with --floor and --window or --door;
    or an opening's id alone ("B07/F1/W3-2").
    """
    from frontage.queries.runfolder import open_run

    found = open_run(out).locate(address, floor=floor, window=window, door=door, facade=facade)
    if as_json:
        click.echo(json.dumps(asdict(found), indent=1, ensure_ascii=False))
    else:
        click.echo("\n".join(_lines(found)))


def _lines(f: "Located") -> list[str]:
    """The answer for people; lengths in m."""
    where = f" of {f.address}" if f.address else ""
    sigma = {name: "?" if s is None else f"{s:.3f}" for name, s in f.sigma.items()}
    depth = "depth not measured" if f.depth is None else f"depth {f.depth:.3f} +- {sigma['depth']} m"
    lines = [
        f"{f.id}: {f.kind}{where}, floor {f.floor}, number {f.number} from the left, bay {f.bay}",
        f"facade: {f.facade}, {f.chosen}",
        f"size: {f.width:.3f} +- {sigma['width']} x {f.height:.3f} +- {sigma['height']} m, {depth}",
        f"sigma: left {sigma['left']}, right {sigma['right']}, bottom {sigma['bottom']}, top {sigma['top']}, "
        f"plane {sigma['plane']} m",
        f"{f.provenance}, confidence {f.confidence:.2f}, {f.shape}",
        *_bars(f),
        f"on the wall, {f.crs or 'no CRS'}:",
        *_corners(f.corners),
        *([f"at its depth, {f.crs or 'no CRS'}:", *_corners(f.corners_inside)] if f.corners_inside else []),
    ]
    if f.pixels:
        c0, r0, c1, r1 = f.pixels
        lines.append(f"ortho-image: columns {c0:z.1f} to {c1:z.1f}, rows {r0:z.1f} to {r1:z.1f}")
    if f.tested:
        lines.append(f"photos ({f.tested}): {'' if f.photos else 'none'}".rstrip())
    for v in f.photos:
        (u0, v0), (u1, v1) = (tuple(m(p[k] for p in v.outline) for k in (0, 1)) for m in (min, max))
        lines.append(
            f"  {v.photo}: columns {u0:.1f} to {u1:.1f}, rows {v0:.1f} to {v1:.1f}, {v.visible:.0%} visible, "
            f"{v.angle:.0f} deg off the normal, {v.gsd * 1000:.1f} mm per pixel"
        )
    return [*lines, *(f"note: {note}" for note in f.notes)]


def _bars(f: "Located") -> list[str]:
    """The line on window bars, if they were looked for."""
    g = f.glazing
    if g is None:
        return []
    if g.vertical is None:
        return [f"window bars: {g.layout}{': ' if g.note else ''}{g.note}"]
    known = [bar.sigma for bar in g.bars if bar.sigma is not None]
    sigma = f", sigma at most {max(known):.3f} m" if known and len(known) == len(g.bars) else ""
    return [f"window bars: {g.layout}{sigma}, confidence {g.confidence:.2f}{'; ' if g.note else ''}{g.note}"]


def _corners(corners: "tuple[Point, ...]") -> list[str]:
    return [
        f"  {name:<12}{x:z.3f} {y:z.3f} {z:z.3f}" for name, (x, y, z) in zip(_CORNERS, corners, strict=True)
    ]
