"""Pictures of a facade's openings in its folder: what they were found from, and what was found."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from frontage.exports import limit_texture
from frontage.model import Elements, Facade
from frontage.openings.observe import ObservedWall
from frontage.openings.paper.find import Decomposition
from frontage.pipeline.files import read_json, write_bytes
from frontage.pipeline.workspace import Workspace
from frontage.report.drawing import opening_picture
from frontage.report.evidence import Picture, beam_picture, cell_pictures

NAMES = ("openings", "evidence", "cells_before", "cells")
"""File stems of all pictures that may be there."""

_LARGEST = 1000  # px of the longer side of the ortho-image under the openings


def save_evidence(
    workspace: Workspace, facade: Facade, evidence: ObservedWall | Decomposition
) -> list[dict[str, Any]]:
    """Write `evidence.png`; by the paper's method also `cells_before.png` and `cells.png`.

    `evidence` is what the openings were found from (`FoundOpenings.evidence`). Returns
    `{"name", "caption", "extent": [x0, z0, x1, z1]}` of the pictures.
    """
    pictures = _pictures(evidence)
    for picture in pictures:
        _write(workspace, facade, picture)
    return [{"name": p.name, "caption": p.caption, "extent": list(p.extent)} for p in pictures]


def draw_openings(
    workspace: Workspace, facade: Facade, elements: Elements, evidence: list[dict[str, Any]]
) -> None:
    """Write `openings.png`, on the ortho-image or else on the first picture that `save_evidence` told of."""
    ground = _ortho(workspace, facade)
    if ground is None and evidence:
        first = evidence[0]
        image = cv2.imread(str(_path(workspace, facade, first["name"])), cv2.IMREAD_UNCHANGED)
        ground = None if image is None else Picture("ground", "", image, tuple(first["extent"]))
    if ground is not None:
        _write(workspace, facade, opening_picture(ground, elements))


def remove_pictures(folder: Path) -> None:
    """Remove what is left of them in a folder, if anything."""
    for name in NAMES:
        (folder / f"{name}.png").unlink(missing_ok=True)


def _write(workspace: Workspace, facade: Facade, picture: Picture) -> None:
    write_bytes(_path(workspace, facade, picture.name), picture.png)


def _path(workspace: Workspace, facade: Facade, name: str) -> Path:
    return workspace.facade_folder(facade.id) / f"{name}.png"


def _pictures(evidence: ObservedWall | Decomposition) -> tuple[Picture, ...]:
    """The pictures of what the openings were found from."""
    if isinstance(evidence, Decomposition):
        return cell_pictures(evidence)
    return (beam_picture(evidence.beams, evidence.evidence),)


def _ortho(workspace: Workspace, facade: Facade) -> Picture | None:
    """The facade's ortho-image, where there is a finished one."""
    done = workspace.done("ortho", facade.building)
    if done is None or facade.id not in done["result"]["orthos"]:
        return None
    folder = workspace.facade_folder(facade.id)
    sidecar = read_json(folder / "ortho.json")
    jpeg = limit_texture((folder / "ortho.jpg").read_bytes(), _LARGEST)
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    x, z = ortho_corner(sidecar, facade)
    w, h = (float(sidecar["gsd"]) * int(sidecar[side]) for side in ("width", "height"))
    return Picture("ortho", "", cv2.cvtColor(image, cv2.COLOR_BGR2BGRA), (x, z - h, x + w, z))


def ortho_corner(sidecar: dict[str, Any], facade: Facade) -> tuple[float, float]:
    """Outer upper left corner (x, z) m of pixel (0, 0) in the facade's frame, from the sidecar's matrix."""
    M = np.array(sidecar["raster_to_world"], np.float64).reshape(4, 4)
    x, _, z = facade.frame.inverse.apply(facade.world.to_local(M[None, :3, 3]))[0]
    return float(x), float(z)
