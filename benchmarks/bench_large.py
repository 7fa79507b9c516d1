"""Ortho-images beyond 32767 px and of a gigapixel: made, written and read; time, size, memory.

python benchmarks/bench_large.py [WIDTH HEIGHT]       px at 1 cm; default 40000 25600, 30 GB of scratch files
"""

import sys
import tempfile
import threading
import time
from pathlib import Path

import cv2
import numpy as np

from _common import table

# isort: split
import ortho_wall as wall  # _common has put tests/ on the path
from frontage.io.ortho import read_ortho, write_ortho
from frontage.model import Scan
from frontage.ortho import OrthoOptions, make_ortho


class Memory:
    """Largest anonymous memory in GB while it runs: what cannot be paged out to the scratch files."""

    def __enter__(self):
        self.peak, self._go = 0.0, True
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()
        self.start = time.perf_counter()
        return self

    def __exit__(self, *_):
        self.seconds = time.perf_counter() - self.start
        self._go = False
        self._thread.join()

    def _watch(self):
        while self._go:
            lines = Path("/proc/self/status").read_text().splitlines()
            anonymous = next(int(v.split()[1]) for v in lines if v.startswith("RssAnon"))
            self.peak = max(self.peak, anonymous * 1024 / 1e9)
            time.sleep(0.05)


def main(width, height):
    w, h = width * wall.GSD, height * wall.GSD
    facade = wall.facade(w, h, spacing=0.5)
    rng = np.random.default_rng(0)
    xyz = np.column_stack(
        [rng.uniform(-w / 2, w / 2, 20_000), np.zeros(20_000), rng.uniform(-h / 2, h / 2, 20_000)]
    )
    scan = Scan("wall", facade.frame.apply(xyz), wall.WORLD)
    photo = wall.photo(facade, wall.camera(4032, 3024, focal=0.7), (0.0, -0.75 * max(w, 1.5 * h), 0.0))
    image = cv2.GaussianBlur(rng.integers(0, 256, (3024, 4032, 3)).astype(np.uint8), (0, 0), 2.0)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        with Memory() as made:
            ortho = make_ortho(facade, scan, [photo], lambda _: image, options=OrthoOptions(margin=0.0))
        rows.append(["made", made])
        with Memory() as written:
            write_ortho(Path(folder), ortho)
        rows.append(["written", written])
        size = sum(f.stat().st_size for f in Path(folder).iterdir()) / 1e9
        with Memory() as read:
            again = read_ortho(Path(folder))
        rows.append(["read", read])
        assert again.size == (width, height) and (again.source[:: height // 50, :: width // 50] == 1).all()
        for r in range(0, height, 4096):
            assert np.array_equal(again.pixels[r : r + 64], ortho.pixels[r : r + 64])
        at = np.array([[width - 0.5, height - 0.5], [0.5, 0.5]])
        back, _ = again.pixel_from_local(again.local_from_pixel(at)[0])
        assert np.abs(back - at).max() < 1e-6
    title = f"{width} x {height} px, {width * height / 1e9:.2f} Gpx, {size:.1f} GB on disk"
    table(
        title, ["step", "seconds", "memory GB"], [[n, f"{m.seconds:.0f}", f"{m.peak:.2f}"] for n, m in rows]
    )


if __name__ == "__main__":
    main(*(int(v) for v in sys.argv[1:3] or ("40000", "25600")))
