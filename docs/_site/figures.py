"""The pictures of the documentation that come from a run of the demo street, and what the examples print.

``python docs/_site/figures.py demo-out/result`` writes the pictures to docs/images and runs every example,
whose output goes to docs/_site/outputs. The street at the top of the README is drawn by examples/picture.py.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"
OUTPUTS = ROOT / "docs" / "_site" / "outputs"
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


def run_examples() -> None:
    """Run every example in an empty folder and keep what it prints, without names of temporary folders."""
    OUTPUTS.mkdir(exist_ok=True)
    for path in sorted((ROOT / "examples").glob("plot_*.py")):
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, str(path)] + (["out.png"] if "argv" in path.read_text("utf-8") else [])
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
            text = re.sub(re.escape(tempfile.gettempdir()) + r"/\w+/", "", done.stdout)
            (OUTPUTS / f"{path.stem}.txt").write_text(text, "utf-8")
            if (Path(folder) / "out.png").exists():
                write(cv2.imread(str(Path(folder) / "out.png")), f"{path.stem}.jpg")
        print(path.name)


def main(run: Path) -> None:
    facade = run / "facades" / "B01_F1"
    write(cv2.imread(str(facade / "evidence.png")), "evidence.jpg")
    write(cv2.imread(str(facade / "openings.png")), "openings.jpg")
    write(cv2.imread(str(facade / "ortho.jpg")), "ortho.jpg")
    write(cv2.imread(str(run / "model" / "pictures" / "B01.png")), "model.jpg")
    run_examples()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
