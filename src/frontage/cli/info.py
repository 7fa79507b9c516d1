"""`frontage info`."""

import json
from pathlib import Path
from typing import Any

import click


@click.command("info")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE...")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def command(files: tuple[Path, ...], as_json: bool) -> None:
    """What files hold: scans, city models, COLMAP folders, run folders.

    Points, extent, CRS, spacing, sensors of scans; buildings, levels of detail, surfaces of city models.
    """
    facts = [_facts(path) for path in files]
    if as_json:
        click.echo(json.dumps(facts if len(facts) > 1 else facts[0], indent=1, ensure_ascii=False))
        return
    for fact in facts:
        click.echo("\n".join(_lines(fact)))


def _facts(path: Path) -> dict[str, Any]:
    if (path / "manifest.json").is_file():
        return _run_folder(path)
    if path.is_dir():
        return _cameras(path)
    from frontage.io.citymodels.info import city_model_info, looks_like_city_model
    from frontage.io.scans.info import scan_info

    return city_model_info(path) if looks_like_city_model(path) else scan_info(path)


def _run_folder(path: Path) -> dict[str, Any]:
    from frontage.pipeline.store.store import Store

    store = Store(path)
    manifest = store.manifest()
    return {
        "path": str(path),
        "format": "run folder",
        "crs": (manifest.world or {}).get("crs"),
        "stages": {name: stage.items for name, stage in manifest.stages.items()},
        "buildings": [record.id for record in store.building_records()],
        "facades": store.facade_ids(),
        "warnings": len(manifest.warnings),
    }


def _cameras(path: Path) -> dict[str, Any]:
    from frontage.io.colmap import read_colmap

    model = read_colmap(path)
    cameras = {
        str(number): f"{camera.model} {camera.width} x {camera.height}"
        for number, camera in model.cameras.items()
    }
    return {
        "path": str(path),
        "format": "COLMAP model",
        "cameras": cameras,
        "photos": [image.name for image in model.images],
    }


def _lines(fact: Any, indent: str = "") -> list[str]:
    """Nested facts as indented `name: value` lines."""
    lines = []
    for name, value in fact.items():
        if isinstance(value, dict):
            lines += [f"{indent}{name}:", *_lines(value, indent + "  ")]
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            lines.append(f"{indent}{name}:")
            for entry in value:
                first, *more = _lines(entry, indent + "    ")
                lines += [f"{indent}  - {first.strip()}", *more]
        else:
            text = ", ".join(str(v) for v in value) if isinstance(value, list) else value
            lines.append(f"{indent}{name}: {'-' if text in (None, '') else text}")
    return lines
