"""Time, size and memory of making, writing and reading ortho-images beyond 32767 px and of a gigapixel.

python benchmarks/bench_large.py [WIDTH HEIGHT]       px at 1 cm; default 40000 25000, 10 GB of scratch files
"""

import json
import subprocess
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
from frontage.io.rasters.ortho import read_ortho, write_ortho
from frontage.model import Scan
from frontage.ortho import OrthoOptions, make_ortho
from frontage.pipeline.store.files import write_json
from frontage.pipeline.store.store import Store
from frontage.raster.tiles import IN_MEMORY, tiles

WINDOW = 4096  # px, what is read at a time


class Memory:
    """Largest anonymous memory in GB while it runs: what cannot be paged out to the scratch files."""

    def __enter__(self):
        self.peak, self._go = 0.0, True
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()
        self.start, self.used = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_):
        self.seconds = time.perf_counter() - self.start
        self.processor = time.process_time() - self.used
        self._go = False
        self._thread.join()

    def _watch(self):
        while self._go:
            lines = Path("/proc/self/status").read_text().splitlines()
            anonymous = next(int(v.split()[1]) for v in lines if v.startswith("RssAnon"))
            self.peak = max(self.peak, anonymous * 1024 / 1e9)
            time.sleep(0.05)


def made_ortho(width, height):
    """A wall of that many pixels at 1 cm, painted from one photo."""
    w, h = width * wall.GSD, height * wall.GSD
    facade = wall.facade(w, h, spacing=0.5)
    rng = np.random.default_rng(0)
    xyz = np.column_stack(
        [rng.uniform(-w / 2, w / 2, 20_000), np.zeros(20_000), rng.uniform(-h / 2, h / 2, 20_000)]
    )
    scan = Scan("wall", facade.frame.apply(xyz), wall.WORLD)
    photo = wall.photo(facade, wall.camera(4032, 3024, focal=0.7), (0.0, -0.75 * max(w, 1.5 * h), 0.0))
    image = cv2.GaussianBlur(rng.integers(0, 256, (3024, 4032, 3)).astype(np.uint8), (0, 0), 2.0)
    return make_ortho(facade, scan, [photo], lambda _: image, options=OrthoOptions(margin=0.0))


def bands(ortho):
    return ortho.pixels, ortho.depth, ortho.source, ortho.gsd_effective


def compare(folder, ortho):
    """Compare every byte of the files with the picture that was written, one window at a time."""
    width, height = ortho.size
    for tile in tiles(height, width, WINDOW):
        part = read_ortho(folder, tile)
        for ours, back in zip(bands(ortho), bands(part), strict=True):
            assert np.ascontiguousarray(ours[tile.window]).tobytes() == back.tobytes(), tile
        assert np.allclose(part.pixel_to_world([[0.5, 0.5]])[0], ortho.pixel_to_world(
            [[tile.c0 + 0.5, tile.r0 + 0.5]])[0], rtol=0, atol=1e-7)  # fmt: skip


def ask(out, at):
    """Run `frontage pixel-to-world` for one pixel as a command and return its answer."""
    command = [
        sys.executable,
        "-m",
        "frontage.cli.main",
        "pixel-to-world",
        out,
        "B01/F1",
        *map(str, at),
        "--json",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    return np.array([answer["x"], answer["y"], answer["z"]])


def main(width, height):
    rows = []
    with tempfile.TemporaryDirectory() as out:
        folder = Path(out) / "facades" / "B01_F1"
        store = Store.create(out)
        write_json(store.buildings_folder / "index.json", {"buildings": [{"id": "B01"}]})
        store.finish("facades", "B01", "", {"facades": ["B01/F1"]})
        with Memory() as made:
            ortho = made_ortho(width, height)
        rows.append(["made", made])
        with Memory() as written:
            write_ortho(folder, ortho)
        rows.append(["written", written])
        with Memory() as read:
            compare(folder, ortho)
        rows.append(["read and compared, every byte", read])
        at = [width - 0.5, 0.3 * height]
        with Memory() as asked:
            answer = ask(out, at)
        rows.append(["pixel-to-world, a process of its own", asked])
        assert np.abs(answer - ortho.pixel_to_world([at])[0]).max() < 1e-6
        back, _ = ortho.world_to_pixel(answer)
        assert np.abs(back - at).max() < 1e-6
        files = {f.name: f.stat().st_size / 1e9 for f in folder.iterdir()}
        scratch = sum(b.nbytes for b in bands(ortho) if b.nbytes > IN_MEMORY and any(b.strides)) / 1e9
    print(", ".join(f"{name} {size:.2f} GB" for name, size in sorted(files.items())))
    title = (
        f"{width} x {height} px, {width * height / 1e9:.2f} Gpx: {sum(files.values()):.1f} GB of files, "
        f"{scratch:.1f} GB of scratch"
    )
    header = ["step", "seconds", "processor s", "memory GB"]
    table(title, header, [[n, f"{m.seconds:.1f}", f"{m.processor:.1f}", f"{m.peak:.2f}"] for n, m in rows])


if __name__ == "__main__":
    main(*(int(v) for v in sys.argv[1:3] or ("40000", "25000")))
