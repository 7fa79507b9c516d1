"""Small files with poses in the formats of other programs, made by hand from the definitions of the formats.

Three cameras whose axes are known: one looks north, one east and 20 degrees up, one north and is rolled by
30 degrees. The angles of the tables were worked out on paper.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.photos.read import PhotoSource
from io_files import picture

WIDTH, HEIGHT = 60, 40
C20, S20, C30, S30 = *(float(f(np.radians(20))) for f in (np.cos, np.sin)), float(np.sqrt(0.75)), 0.5


@dataclass(frozen=True)
class Known:
    """A camera whose axes and position in the world (m) are known, and its angles in the two tables (deg)."""

    name: str
    right: tuple[float, float, float]
    down: tuple[float, float, float]
    forward: tuple[float, float, float]
    centre: tuple[float, float, float]
    opk: tuple[float, float, float]
    heading_pitch_roll: tuple[float, float, float]

    @property
    def axes(self) -> Float:
        """The rotation (3, 3) from the world to the camera: its axes, one per row."""
        return np.array([self.right, self.down, self.forward], np.float64)


CAMERAS = (
    Known("north.jpg", (1, 0, 0), (0, 0, -1), (0, 1, 0), (4.0, -9.0, 2.0), (90, 0, 0), (0, 90, 0)),
    Known("east.jpg", (0, -1, 0), (S20, 0, -C20), (C20, 0, S20), (-8.0, 5.0, 1.5), (180, -70, 90),
          (90, 110, 0)),
    Known("rolled.jpg", (C30, 0, -S30), (-S30, 0, -C30), (0, 1, 0), (5.0, -7.0, 3.0), (90, 0, -30),
          (90, 60, 90)),
)  # fmt: skip
POINTS = np.array([[4.3, 8.0, 5.0], [6.0, 5.1, 4.0], [5.5, 6.0, 3.5], [7.0, 4.5, 6.0]])

RADIAL, TANGENTIAL = (-0.11, 0.04, -0.02), (0.0021, -0.0034)
"""k1, k2, k3, and p1, p2 in OpenCV's order."""


def pixels(known: Known, focal: tuple[float, float], centre: tuple[float, float], points: Float) -> Float:
    """The pixels (n, 2) of points by the definition of the distortion; every format states it this way."""
    X, Y, Z = known.axes @ (points - known.centre).T
    assert (Z > 0).all()
    x, y = X / Z, Y / Z
    q, (k1, k2, k3), (p1, p2) = x * x + y * y, RADIAL, TANGENTIAL
    bent = 1 + k1 * q + k2 * q**2 + k3 * q**3
    u = x * bent + 2 * p1 * x * y + p2 * (q + 2 * x * x)
    v = y * bent + 2 * p2 * x * y + p1 * (q + 2 * y * y)
    return np.column_stack([focal[0] * u + centre[0], focal[1] * v + centre[1]])


def pictures(folder: Path, names: Sequence[str] = tuple(c.name for c in CAMERAS)) -> Path:
    """The picture files."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(picture(WIDTH, HEIGHT))
    return folder


def source(tmp_path: Path, cameras: Path) -> PhotoSource:
    """The photos in "pictures" with the cameras in a file."""
    return PhotoSource(path=str(tmp_path / "pictures"), cameras=str(cameras))


def metashape(
    path: Path, reference: str = "", chunk: str = "", cameras: str = "", calibration: str = ""
) -> Path:
    """A camera file in local coordinates: f = 50, b1 = 1, principal point 1.5 and -0.5 px off the centre."""
    (k1, k2, k3), (p1, p2) = RADIAL, TANGENTIAL
    listed = cameras or "".join(
        f'<camera id="{k}" sensor_id="3" label="{c.name.removesuffix(".jpg")}"><transform>'
        + " ".join(
            map(repr, np.block([[c.axes.T, np.array(c.centre)[:, None]], [0.0, 0, 0, 1]]).ravel().tolist())
        )
        + "</transform></camera>"
        for k, c in enumerate(CAMERAS)
    )
    # Metashape's p1 belongs to r^2 + 2 x^2 and its p2 to 2 x y in x', the other way round than OpenCV's.
    inner = calibration or (
        f"<f>50</f><cx>1.5</cx><cy>-0.5</cy><b1>1</b1><k1>{k1}</k1><k2>{k2}</k2><k3>{k3}</k3>"
        f"<p1>{p2}</p1><p2>{p1}</p2>"
    )
    size = f'<resolution width="{WIDTH}" height="{HEIGHT}"/>'
    path.write_text(
        '<?xml version="1.0" encoding="UTF-8"?>\n<document version="2.0.0">'
        '<chunk label="Chunk 1" enabled="true"><sensors next_id="4">'
        f'<sensor id="3" label="a camera" type="frame">{size}'
        f'<calibration type="frame" class="initial">{size}<f>999</f></calibration>'
        f'<calibration type="frame" class="adjusted">{size}{inner}</calibration></sensor></sensors>'
        f'<cameras next_id="9">{listed}</cameras><reference>{reference}</reference>{chunk}</chunk>'
        "</document>\n"
    )
    return path


def opensfm_shots() -> dict[str, object]:
    """The shots: `rotation` is axis times angle from the world to the camera."""
    return {
        c.name: {
            "rotation": cv2.Rodrigues(c.axes)[0].ravel().tolist(),
            "translation": (-c.axes @ c.centre).tolist(),
            "camera": "v2 some camera",
        }
        for c in CAMERAS
    }


def opensfm(path: Path, **more: object) -> Path:
    """A reconstruction whose lengths are in shares of the longer side, 60 px."""
    (k1, k2, k3), (p1, p2) = RADIAL, TANGENTIAL
    camera = {"projection_type": "brown", "width": WIDTH, "height": HEIGHT, "focal_x": 51 / 60,
              "focal_y": 50 / 60, "c_x": 1.5 / 60, "c_y": -0.5 / 60,
              "k1": k1, "k2": k2, "k3": k3, "p1": p1, "p2": p2}  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    part = {"cameras": {"v2 some camera": camera}, "shots": opensfm_shots(), "points": {}, **more}
    path.write_text(json.dumps([part]))
    return path


def pix4d(folder: Path, cameras: str = "per photo") -> Path:
    """A Pix4D table of omega, phi, kappa with its cameras, "per photo", "cam" or "colmap"."""
    (k1, k2, k3), (p1, p2) = RADIAL, TANGENTIAL
    folder.mkdir(parents=True, exist_ok=True)
    rows = ["imageName X Y Z Omega Phi Kappa"]
    rows += [" ".join([c.name, *map(repr, c.centre), *map(repr, c.opk)]) for c in CAMERAS]
    table = folder / "street_calibrated_external_camera_parameters.txt"
    table.write_text("\n".join(rows) + "\n")
    if cameras == "per photo":
        text = (
            "fileName imageWidth imageHeight \ncamera matrix K [3x3]\nradial distortion [3x1]\n"
            "tangential distortion [2x1]\ncamera position t [3x1]\ncamera rotation R [3x3]\n"
            "camera model m = K [R|-Rt] X\n\n"
        )
        for c in CAMERAS:
            text += f"{c.name} {WIDTH} {HEIGHT}\n51 0 31.5\n0 50 19.5\n0 0 1\n{k1} {k2} {k3}\n{p1} {p2}\n"
            text += "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        (folder / "street_calibrated_camera_parameters.txt").write_text(text)
    elif cameras == "cam":  # 60 px are 12 mm: 0.2 mm per pixel
        (folder / "street_pix4d_calibrated_internal_camera_parameters.cam").write_text(
            "Pix4D camera calibration file 0\n#Focal Length mm assuming a sensor width of 12.0x8.0mm\n"
            "F 10.0\n"
            "#Principal Point mm\nPx 6.3\nPy 3.9\n#Symmetrical Lens Distortion Coeffs\n"
            f"K1 {k1}\nK2 {k2}\nK3 {k3}\n#Tangential Lens Distortion Coeffs\nT1 {p1}\nT2 {p2}\n"
        )
    elif cameras == "colmap":
        (folder / "cameras.txt").write_text(
            f"# a comment\n1 FULL_OPENCV {WIDTH} {HEIGHT} 51 50 31.5 19.5 {k1} {k2} {p1} {p2} {k3} 0 0 0\n"
        )
    return table


def realityscan(path: Path) -> Path:
    """A RealityScan table: f on a film 36 mm wide, so that 30 mm are 50 px of 60."""
    (k1, k2, k3), (t1, t2) = RADIAL, TANGENTIAL
    rows = ["#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2"]
    for c in CAMERAS:
        pose = ",".join(map(repr, (*c.centre, *c.heading_pitch_roll)))
        rows.append(f"{c.name},{pose},30,{1.5 / 60!r},{-0.5 / 60!r},{k1},{k2},{k3},0,{t1},{t2}")
    path.write_text("\n".join(rows) + "\n")
    return path
