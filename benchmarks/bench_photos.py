"""Simulated photographs: seconds for 12 megapixels, matches of neighbours, figures next to real photos.

    python benchmarks/bench_photos.py [--scenes 6] [--quick]

Wall seconds need an idle machine; processor seconds are printed with them. Figures of pictures are taken at
1200 px width from the simulated photos and from real ones (castle_photos, where present): SIFT features per
megapixel, gradients, slope of the power spectrum over frequency.
"""

import argparse
import time

import cv2
import numpy as np

from _common import DATA, bootstrap, figure, table
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.photograph import iter_photographs, lit_scene_of, take_photographs
from frontage.simulate.sensors.recording import Shot
from frontage.simulate.sensors.viewpoints import plan_photos
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

WIDTH = 1200
SIFT = 0.02  # contrast threshold, that of COLMAP


def time_12_megapixels(seeds: range) -> None:
    rows = []
    for seed in seeds:
        scene, spec = build_street(SceneSpec(seed=seed)), CameraSpec(most=1)
        lit_scene_of(scene, spec.light)
        wall, cpu = time.perf_counter(), time.process_time()
        take_photographs(scene, spec, seed)
        rows.append((time.perf_counter() - wall, time.process_time() - cpu))
    wall, cpu = np.array(rows).T
    table(
        "One photo of 12 megapixels (target: 20 s on 2 cores)",
        ("scenes", "wall s", "processor s"),
        [(len(rows), figure(bootstrap(wall)), figure(bootstrap(cpu)))],
    )


def grey(image: np.ndarray) -> np.ndarray:
    size = WIDTH, round(WIDTH * image.shape[0] / image.shape[1])
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA) if image.shape[1] != WIDTH else image
    return cv2.cvtColor(small, cv2.COLOR_RGB2GRAY)


def look(image: np.ndarray) -> tuple[float, ...]:
    """Return features per megapixel, median, 90 and 99 % gradient, and slope of the spectrum."""
    g = grey(image)
    features = len(cv2.SIFT_create(contrastThreshold=SIFT).detect(g, None)) / g.size * 1e6
    g = g.astype(np.float64)
    gradient = np.hypot(cv2.Sobel(g, cv2.CV_64F, 1, 0), cv2.Sobel(g, cv2.CV_64F, 0, 1)) / 8
    return features, *np.quantile(gradient, [0.5, 0.9, 0.99]), spectrum_slope(g)


def spectrum_slope(g: np.ndarray) -> float:
    """Exponent of the power spectrum between 0.01 and 0.4 cycles per pixel; photos have -2 to -3."""
    n = min(g.shape)
    window = np.hanning(n)
    power = np.abs(np.fft.fft2((g[:n, :n] - g[:n, :n].mean()) * window[:, None] * window)) ** 2
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(n), np.fft.fftfreq(n)))
    edges = np.geomspace(0.01, 0.4, 12)
    ring = np.digitize(f.ravel(), edges)
    mean = [power.ravel()[ring == k].mean() for k in range(1, len(edges))]
    return float(np.polyfit(np.log(np.sqrt(edges[1:] * edges[:-1])), np.log(mean), 1)[0])


def matches(a: Shot, b: Shot) -> tuple[int, float]:
    """SIFT matches (ratio 0.8) within 1.5 px of the epipolar plane, and their share of all."""
    sift = cv2.SIFT_create(contrastThreshold=SIFT)
    (ka, da), (kb, db) = (sift.detectAndCompute(grey(s.image), None) for s in (a, b))
    pairs = cv2.BFMatcher().knnMatch(da, db, k=2)
    good = [m for m, n in pairs if m.distance < 0.8 * n.distance]
    (ca, ra), (cb, rb) = (
        s.photo.ray(np.array([k[i].pt for i in at]) + 0.5)
        for s, k, at in ((a, ka, [m.queryIdx for m in good]), (b, kb, [m.trainIdx for m in good]))
    )
    normal = np.cross(cb - ca, ra)
    off = np.einsum("ij,ij->i", normal, rb) / np.linalg.norm(normal, axis=1)
    true = np.abs(off) * a.photo.camera.params[0] < 1.5
    return int(true.sum()), float(true.mean())


def picture_figures(seeds: range) -> None:
    looks, pairs = [], []
    for seed in seeds:
        spec = CameraSpec(width=WIDTH, height=WIDTH * 3 // 4, most=60)
        a, b = middle_photos(seed, spec)
        looks.append(look(a.image))
        pairs.append(matches(a, b))
    kinds = {"simulated": np.array(looks)}
    files = sorted((DATA / "castle_photos" / "images").glob("*.jpg"))[::2]
    if files:
        kinds["real: castle"] = np.array([look(cv2.imread(str(f))[..., ::-1]) for f in files])
    table(
        f"Figures of pictures {WIDTH} px wide (mean over photos with 95 % interval)",
        ("photos", "features / Mpx", "gradient 50 %", "90 %", "99 %", "spectrum"),
        [
            (f"{name} ({len(v)})", *(figure(bootstrap(column, np.mean)) for column in v.T))
            for name, v in kinds.items()
        ],
    )
    count, share = np.array(pairs).T
    table(
        "SIFT matches of neighbouring photos (target: 500)",
        ("pairs", "least", "true matches", "share of all"),
        [(len(pairs), int(count.min()), figure(bootstrap(count)), figure(bootstrap(share)))],
    )


def middle_photos(seed: int, spec: CameraSpec) -> tuple[Shot, Shot]:
    """The two photos in the middle of a walk."""
    scene = build_street(SceneSpec(seed=seed))
    middle = len(plan_photos(scene, spec, seed)) // 2
    a, b = iter_photographs(scene, spec, seed, only=[middle - 1, middle])
    return a, b


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=6)
    parser.add_argument("--quick", action="store_true", help="no timing")
    arguments = parser.parse_args()
    if not arguments.quick:
        time_12_megapixels(range(100, 100 + max(2, arguments.scenes // 2)))
    picture_figures(range(100, 100 + arguments.scenes))


if __name__ == "__main__":
    main()
