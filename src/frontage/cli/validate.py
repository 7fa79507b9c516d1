"""`frontage validate`."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frontage.cli.console import common

if TYPE_CHECKING:
    from frontage.model import Finding
    from frontage.queries.validation import FileFindings

_PATH = click.Path(path_type=Path)
_PRIMITIVES = click.Choice(["Solid", "CompositeSurface", "MultiSurface"])


@click.command("validate")
@click.argument("files", nargs=-1, required=True, type=_PATH, metavar="FILE...")
@click.option(
    "--snap-tol", type=float, default=0.001, show_default=True, help="Vertices so close are one, m."
)
@click.option("--planarity-d2p-tol", type=float, default=0.01, show_default=True, help="Vertex to plane, m.")
@click.option(
    "--planarity-n-tol", type=float, default=20.0, show_default=True, help="Normals in a face, deg."
)
@click.option(
    "--overlap-tol", type=float, default=-1.0, show_default=True, help="Between solids, m; -1: none."
)
@click.option("-p", "--primitive", type=_PRIMITIVES, default="Solid", help="What OBJ, OFF, POLY faces form.")
@click.option("--inner", multiple=True, type=_PATH, help="Inner shell of the one OBJ, OFF or POLY FILE.")
@common
def command(
    files: tuple[Path, ...],
    snap_tol: float,
    planarity_d2p_tol: float,
    planarity_n_tol: float,
    overlap_tol: float,
    primitive: str,
    inner: tuple[Path, ...],
    quiet: bool,
    as_json: bool,
) -> None:
    """Check solids against ISO 19107, with val3dity's error codes (docs/methods/validation.md).

    Reads CityJSON, CityJSONSeq, CityGML, IndoorGML, JSON-FG, OBJ, OFF, POLY. Exit code 0: all valid,
    1: something was found, or a file cannot be read.
    """
    from pydantic import ValidationError

    from frontage.queries.validation import validate_file
    from frontage.validation import Tolerances

    if inner and len(files) > 1:
        raise click.UsageError("--inner goes with one FILE")
    try:
        tolerances = Tolerances(
            snap=snap_tol,
            planarity_distance=planarity_d2p_tol,
            planarity_normals=planarity_n_tol,
            overlap=overlap_tol,
        )
    except ValidationError as error:
        first = error.errors()[0]
        raise click.UsageError(f"tolerance {first['loc'][0]}: {first['msg'].lower()}") from None
    found = [validate_file(path, tolerances, primitive, inner) for path in files]  # type: ignore[arg-type]
    if as_json:
        click.echo(json.dumps(_table(found, tolerances.model_dump()), indent=1, ensure_ascii=False))
    else:
        for file in found:
            _tell(file, quiet)
    if not all(file.valid for file in found):
        raise click.exceptions.Exit(1)


def _tell(file: "FileFindings", quiet: bool) -> None:
    """One line per finding, then one for the file; a file that cannot be read is a sentence on stderr."""
    if not file.format:
        finding = file.findings[0]
        click.echo(f"frontage: {finding.message} [{finding.code} {_name(finding)}]", err=True)
    elif not quiet:
        for finding in file.findings:
            click.echo(f"{file.path}: {_line(finding)}")
    if not quiet:
        click.echo(_summary(file))


def _name(finding: "Finding") -> str:
    from frontage.validation import NAMES

    return NAMES[finding.code]


def _line(finding: "Finding") -> str:
    """Code, name, feature, geometry and face, what, where in the world."""
    from frontage.validation import QIE_NAMES

    name = _name(finding)
    if finding.qie is not None:
        name += f" (QIE {finding.qie} {QIE_NAMES[finding.qie]})"
    place = " ".join(x for x in (name, finding.feature, finding.where) if x)
    at = "" if finding.location is None else " at {:.4f} {:.4f} {:.4f}".format(*finding.location)
    return f"{finding.code} {place}: {finding.message}{at}"


def _summary(file: "FileFindings") -> str:
    if not file.format:
        return f"{file.path}: not checked"
    features, geometries = sum(file.features.values()), sum(file.geometries.values())
    kinds = ", ".join(f"{number} {kind}" for kind, number in file.geometries.items()) or "no geometry"
    verdict = "valid"
    if not file.valid:
        codes = ", ".join(f"{code} x {number}" for code, number in file.codes.items())
        verdict = f"INVALID, {len(file.findings)} findings ({codes})"
    size = f"{features} features, {geometries} geometries ({kinds})"
    return f"{file.path}: {verdict}; {file.format}, {size}"


def _table(found: "list[FileFindings]", tolerances: dict[str, float]) -> dict[str, Any]:
    """Everything, JSON-able."""
    return {
        "valid": all(file.valid for file in found),
        "codes": sorted({code for file in found for code in file.codes}),
        "tolerances": tolerances,
        "files": [
            {
                "path": str(file.path),
                "valid": file.valid,
                "format": file.format,
                "features": file.features,
                "geometries": file.geometries,
                "codes": {str(code): number for code, number in file.codes.items()},
                "findings": [_row(finding) for finding in file.findings],
            }
            for file in found
        ],
    }


def _row(finding: "Finding") -> dict[str, Any]:
    row = {
        "code": finding.code,
        "name": _name(finding),
        "feature": finding.feature,
        "where": finding.where,
        "message": finding.message,
        "location": finding.location,
    }
    return row if finding.qie is None else row | {"qie": finding.qie}
