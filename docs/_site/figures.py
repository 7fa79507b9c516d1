"""The pictures of the documentation that come from a run of the demo street.

``python docs/_site/figures.py demo-out/result`` writes them to docs/images.
The street at the top of the README is drawn by examples/picture.py.
"""

import sys
from pathlib import Path

import cv2
import numpy as np

IMAGES = Path(__file__).resolve().parents[1] / "images"
WIDTH = 900  # px
LARGEST = 160_000  # bytes


def write(picture: np.ndarray, name: str) -> None:
    """Shrink a picture (h, w, 3) BGR to the page's width and write it as JPEG below the size limit."""
    factor = min(1.0, WIDTH / picture.shape[1])
    picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    quality = 90
    while True:
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if len(data) <= LARGEST or quality <= 40:
            break
        quality -= 8
    (IMAGES / name).write_bytes(data.tobytes())
    print(name, picture.shape[1::-1], len(data))


def main(run: Path) -> None:
    facade = run / "facades" / "B01_F1"
    write(cv2.imread(str(facade / "evidence.png")), "evidence.jpg")
    write(cv2.imread(str(facade / "openings.png")), "openings.jpg")
    write(cv2.imread(str(facade / "ortho.jpg")), "ortho.jpg")
    write(cv2.imread(str(run / "model" / "pictures" / "B01.png")), "model.jpg")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
