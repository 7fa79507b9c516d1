"""The project file of a simulated scene: what `frontage run` reads."""

import json
from typing import Any

from frontage.model import WorldRef
from frontage.simulate.spec import SceneSpec
from frontage.studies.measurements import MOBILE


def project_text(spec: SceneSpec, world: WorldRef, table: dict[str, Any]) -> str:
    """TOML with the scans, photos and city model of a scene; `table` = the contents of truth.json."""
    lines = [f"# simulated scene {spec.name!r}, seed {spec.seed}; the truth is in truth/", "[project]"]
    lines.append(f"name = {json.dumps(spec.name, ensure_ascii=False)}")
    if world.crs is not None:
        lines.append(f'crs = "{world.crs}"')
    lines += ["seed = 0"]
    series = [
        scanner
        for scanner in spec.scanners
        for _ in range(scanner.stations if scanner.positions is None else len(scanner.positions))
    ]
    for scanner, station in zip(series, table["stations"], strict=True):
        lines += ["", "[[scans]]", f'path = "{station["file"]}"']
        if spec.output.scans == "ptx" and world.crs is not None:
            lines.append(f'crs = "{world.crs}"')
        if scanner.pose == "approximate":
            lines += ['pose = "approximate"', f"sigma_position = {scanner.sigma_position}"]
            lines += [f"sigma_heading = {scanner.sigma_heading}", f"sigma_level = {scanner.sigma_level}"]
    if table["drive"] is not None:
        lines += ["", "[[scans]]", f'path = "{MOBILE}"', f'trajectory = "{table["drive"]["trajectory"]}"']
    if table["photos"]:
        lines += ["", "[photos]", 'path = "photos/*.jpg"']
        lines += ['cameras = "cameras"     # true poses; cameras_approximate has those of GPS and compass']
    lines += ["", "[model]", 'path = "lod2.city.json"     # with the errors of a surveying office']
    lines += ["", "[ortho]", f"gsd = {spec.output.gsd}"]
    return "\n".join(lines) + "\n"
