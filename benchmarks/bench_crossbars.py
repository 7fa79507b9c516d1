"""Window bars: exact layouts, bars found, positions, depths, their errors and the time; curves; real windows.

    python benchmarks/bench_crossbars.py [--quick | --full] [--houses 6] [--first 500] [--oriented FOLDER]
                                         [--only main,views,castle,...] [--sheet FOLDER]
                                         [--cache FOLDER] [--data FOLDER]

Simulated: the middle house of a terrace with varied windows (`windows = "varied"`), six of its windows,
photographed from the street at 5 mm per px. Borders of the openings are off by 5 mm, depths by 2 cm, poses
by 3 mm and 0.01 degrees (one sigma each). Beside ours, on the same windows: the paper's method (matched edges
and templates), and straight segments of the best view that vote (OpenCV's LSD).

"Exact layout" is the share of all windows: an undecided one is not exact. "Exact where decided" leaves these
out. The depth is that of the bars' front faces. Confidence is fitted on one half of the houses and checked on
the other. `--full` takes 16 houses, and 8 for the curves; otherwise the curves are those of the first four.

Real: the scene of real buildings' models (photos and scan), the castle photos (hand-made outlines and layouts
in _barcases.py), and the scans with annotated bars (no photos). With `--oriented`, the scene's photos also
have the poses that `frontage orient` found (the folder orientation/colmap of its run). The pictures are
rendered once and kept in `--cache`; a house takes about a minute on one core. Houses that are only scanned
are seen from the other side of the street, by one scanner or two.
"""

import argparse
import multiprocessing
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from _barcases import Case, annotated, castle, ingolstadt, simulated
from _barconfidence import confidence_tables
from _barscans import scanned
from _barscore import HEADER, Judged, judge, reliability, summary
from _common import DATA, table
from _linegrid import bars_by_segments
from _windows import WindowScene, WindowSet, window_scene
from frontage.crossbars import CrossbarOptions, FoundBars
from frontage.crossbars.collect import collect_windows
from frontage.crossbars.find import find_bars

FIRST = 500  # number of the first house; tests and trials use smaller ones
FIRST_SCAN = 2100  # number of the first house that is only scanned; 2000 to 2019 were developed on
SPACINGS = (0.010, 0.014, 0.020, 0.030, 0.040)  # m between points on the wall
ERRORS = {"position": 0.003, "angle": 0.01}
SUBSETS = {1: (2,), 2: (1, 4), 3: (0, 2, 5), 4: (0, 2, 3, 5), 6: (0, 1, 2, 3, 4, 5)}
METHODS = ("evidence", "paper", "segments")
SECTIONS = (
    "main",
    "exact",
    "speed",
    "views",
    "gsd",
    "oblique",
    "ingolstadt",
    "castle",
    "brooklyn",
    "manhattan",
    "scans",
)
CURVES = (*HEADER[:7], *HEADER[8:11])
NAMES = {"evidence": "ours", "paper": "the paper's", "segments": "LSD votes, one view"}


def found_by(case: Case, method: str) -> FoundBars:
    """Run one method on a case."""
    if method == "segments":
        windows = collect_windows(case.facade, case.elements, case.photos, case.image_of, case.scan)
        return bars_by_segments(case.elements, windows, CrossbarOptions())
    options = CrossbarOptions.model_validate({"method": method})
    return find_bars(case.facade, case.elements, case.photos, case.image_of, case.scan, options)


def judged(cases: Iterable[Case], method: str, sheet: Path | None = None) -> tuple[list[Judged], float]:
    """Judge a method on cases; also returns processor seconds per 100 windows and 6 views."""
    out: list[Judged] = []
    spent = views = 0.0
    for case in cases:
        images = {p.id: case.image_of(p.id) for p in case.photos}  # reading them is not what is timed
        start = time.process_time()
        found = found_by(replace(case, image_of=images.__getitem__), method)
        spent += time.process_time() - start
        views += sum(min(len(o.photos), 8) for o in found.elements.openings if o.id in case.truth)
        for opening in found.elements.openings:
            if opening.id in case.truth:
                out.append(judge(case.name, opening.id, case.truth[opening.id], opening.glazing))
        if sheet is not None:
            draw_sheet(found, case, sheet / f"{case.name.replace(' ', '_')}_{method}.png")
    return out, spent / views * 600 if views else float("nan")


def compare(
    title: str, cases: Callable[[], Iterable[Case]], methods: Sequence[str], sheet: Path | None = None
) -> list[Judged]:
    """Print the table of some methods on the same cases; returns what the first one found."""
    rows, first = [], None
    for method in methods:
        own, spent = judged(cases(), method, sheet)
        first = first or own
        rows.append([NAMES[method], *summary(own), "-" if np.isnan(spent) else f"{spent:.0f}"])
    table(title, ("method", *HEADER, "s per 100 x 6"), rows)
    return first or []


def scenes(houses: int, cache: Path, first: int = FIRST, **changes: object) -> Callable[..., Iterable[Case]]:
    """Return what makes the cases of some houses: all views, or some; reduced by a factor."""
    base = WindowSet(first, gsd=0.005, views=6, most=6, **ERRORS)
    asked = [replace(base, seed=first + k, **changes) for k in range(houses)]  # type: ignore[arg-type]

    built: list[WindowScene] = []

    def make(views: Sequence[int] | None = None, reduce: int = 1) -> Iterable[Case]:
        built.extend(window_scene(a, cache) for a in asked[len(built) :])
        return (simulated(scene, views, reduce) for scene in built)

    return make


def main_table(houses: int, cache: Path, sheet: Path | None, first: int) -> None:
    make = scenes(houses, cache, first)
    own = compare(
        f"{houses} houses, 5 mm per px, 4 views, poses 3 mm and 0.01 degrees off",
        lambda: make(SUBSETS[4]), METHODS, sheet,
    )  # fmt: skip
    leaded = [j for j in own if j.exact is None]
    if leaded:
        told = sum(not j.resolved for j in leaded)
        print(f"\nOf {len(leaded)} leaded windows, ours leaves {told} as not resolved.")
    kinds(own)
    failures(own)
    few = judged(make(SUBSETS[2]), METHODS[0])[0]
    confidence_tables([*own, *few], [f"house {first + k}" for k in range(houses)])


def exact_table(houses: int, cache: Path, first: int) -> None:
    """Print what errors of poses, outlines and depths cost: the table without them."""
    exact = scenes(houses, cache, first, position=0.0, angle=0.0, outline=0.0, depth=0.001)
    title = f"{houses} houses with exact poses, outlines and depths"
    compare(title, lambda: exact(SUBSETS[4]), METHODS[:2])


def speed(houses: int, cache: Path) -> None:
    """Print how long windows with six views take two workers, a facade each, as in a run."""
    cases = [replace(c, truth={}) for c in scenes(max(2, min(houses, 4)), cache)(SUBSETS[6])]
    images = [{p.id: c.image_of(p.id) for p in c.photos} for c in cases]  # reading them is not what is timed
    _TIMED[:] = [replace(c, image_of=i.__getitem__) for c, i in zip(cases, images, strict=True)]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        start = time.perf_counter()
        found = pool.map(_timed, range(len(cases)), chunksize=1)
        wall = time.perf_counter() - start
    windows, spent = (sum(column) for column in zip(*found, strict=True))
    print(
        f"\n{windows:.0f} windows x 6 views of {len(cases)} facades with two workers: {wall:.1f} s, "
        f"{spent:.1f} s of processor time; 100 windows in {100 * wall / windows:.0f} s."
    )


_TIMED: list[Case] = []  # what the workers inherit


def _timed(number: int) -> tuple[float, float]:
    """Find the bars of one case; returns the number of its windows and the processor seconds."""
    start = time.process_time()
    windows = len(found_by(_TIMED[number], METHODS[0]).windows)
    return windows, time.process_time() - start


def failures(own: Sequence[Judged]) -> None:
    """List the windows that are not exact."""
    for j in own:
        if j.exact is False:
            what = f"not resolved: {j.note}" if not j.resolved else f"{j.hits} of {j.found} bars right"
            print(f"- {j.case} {j.window}: {what}, {j.true} true, confidence {j.confidence:.2f}")


def kinds(own: Sequence[Judged]) -> None:
    """Print how often layouts are exact by the number of true bars, and why windows are left undecided."""
    rows = []
    for low, high in ((0, 0), (1, 1), (2, 2), (3, 4), (5, 99)):
        some = [j for j in own if j.exact is not None and low <= j.true <= high]
        if some:
            name = str(low) if low == high else f"{low} - {high}" if high < 99 else f"{low} and more"
            rows.append([name, *summary(some)[:6]])
    table("Ours by the number of bars (pieces) of a window", ("bars", *HEADER[:6]), rows)


def curves(houses: int, cache: Path, only: Sequence[str]) -> None:
    make = scenes(houses, cache)
    if "views" in only:
        rows = []
        for n, views in SUBSETS.items():
            rows += curve_rows(str(n), lambda: make(views))  # noqa: B023
        table(f"{houses} houses: number of views, 5 mm per px", ("views", "method", *CURVES), rows)
    if "gsd" in only:
        rows = []
        fine = scenes(min(houses, 8), cache, gsd=0.0025, views=3, most=2)
        rows += curve_rows("2.5", fine)
        for reduce in (1, 2, 3):
            rows += curve_rows(str(5 * reduce), lambda: make(SUBSETS[3], reduce))  # noqa: B023
        table(f"{houses} houses: mm per px, 3 views", ("mm", "method", *CURVES), rows)
    if "oblique" in only:
        rows = []
        for degrees in (0.0, 20.0, 35.0, 50.0, 65.0):
            some = scenes(min(houses, 4), cache, oblique=degrees, views=3, most=4)
            rows += curve_rows(f"{degrees:.0f}", some)
        title = (
            f"{min(houses, 4)} houses: degrees from the wall's normal, 3 views within 20 degrees, "
            "5 mm per px across the line of sight"
        )
        table(title, ("degrees", "method", *CURVES), rows)


def curve_rows(name: str, cases: Callable[[], Iterable[Case]]) -> list[list[str]]:
    rows = []
    for method in METHODS[:2]:
        cells = summary(judged(cases(), method)[0])
        rows.append([name, NAMES[method], *cells[:7], *cells[8:11]])
    return rows


def real(only: Sequence[str], data: Path, sheet: Path | None, oriented: Path | None) -> None:
    for folder, title, cases, methods in (
        ("ingolstadt_scene", "Ingolstadt: photos with true poses, scan of 2 cm",
         lambda: ingolstadt(data), METHODS),
        ("ingolstadt_scene", "Ingolstadt: photos with poses from frontage orient, scan of 2 cm",
         lambda: ingolstadt(data, oriented) if oriented else [], METHODS[:2]),
        ("castle_photos", "Castle: real photos, 11 mm per px, no scan", lambda: castle(data), METHODS),
        ("brooklyn_row", "Brooklyn: real scan, 9 mm and coarser, no photos",
         lambda: annotated(data, "brooklyn_row"), METHODS[:1]),
        ("manhattan_apartment", "Manhattan: real scan, 16-20 mm, no photos",
         lambda: annotated(data, "manhattan_apartment"), METHODS[:1]),
    ):  # fmt: skip
        if folder.split("_")[0] not in only:
            continue
        if not (data / folder).is_dir():
            print(f"\n{title}: left out, {folder} is not in {data.name}")
            continue
        kept = list(cases())
        if not kept:
            continue
        own = compare(title, lambda: kept, methods, sheet)  # noqa: B023
        failures(own)


def draw_sheet(found: FoundBars, case: Case, file: Path) -> None:
    """Save the first view of every window with the true bars (green) and the found ones (red)."""
    tiles = []
    for w in found.windows:
        if not w.views or w.opening not in case.truth:
            continue
        picture = cv2.resize(w.views[0][1], (220, 330), interpolation=cv2.INTER_AREA)[..., ::-1].copy()
        x0, z0, x1, z1 = w.extent
        for bars, colour, shift in (
            (case.truth[w.opening].bars, (0, 220, 0), 0),
            (w.glazing.bars, (0, 0, 255), 2),
        ):
            for b in bars:
                ends = [(b.position, e) if b.axis == "vertical" else (e, b.position) for e in b.extent]
                at = [
                    (int(220 * (x - x0) / (x1 - x0)) + shift, int(330 * (z1 - z) / (z1 - z0)) + shift)
                    for x, z in ends
                ]
                cv2.line(picture, at[0], at[1], colour, 1)
        text = f"{w.glazing.confidence:.2f}" if w.glazing.resolved else w.glazing.note[:30]
        cv2.putText(picture, text, (4, 14), 0, 0.4, (0, 255, 255), 1)
        tiles.append(picture)
    if tiles:
        tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % 8 if len(tiles) > 8 else 0)
        wide = min(8, len(tiles))
        file.parent.mkdir(parents=True, exist_ok=True)
        rows = [np.hstack(tiles[k : k + wide]) for k in range(0, len(tiles), wide)]
        cv2.imwrite(str(file), np.vstack(rows))


def scans(houses: int, cache: Path) -> None:
    """Print how well scans from the street do without photos, by the spacing of their points."""
    found: dict[float, list[Judged]] = {}
    for k in range(FIRST_SCAN, FIRST_SCAN + houses):
        spacing, stations = SPACINGS[k % len(SPACINGS)], 1 + k // len(SPACINGS) % 2
        reveal = float(np.random.default_rng(k).uniform(0.1, 0.38))
        case = scanned(k, spacing, stations, cache=cache, reveal=reveal)
        found.setdefault(spacing, []).extend(judged([case], METHODS[0])[0])
    every = [j for own in found.values() for j in own]
    rows = [[f"{1000 * s:.0f}", *summary(found[s])] for s in sorted(found)] + [["all", *summary(every)]]
    table(f"{houses} houses, only scanned, mm between points", ("mm", *HEADER), rows)
    header = ("confidence", "windows", "mean", "exact")
    table("Confidence of windows that are only scanned", header, reliability(every))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="two windows of one house, under a minute")
    parser.add_argument("--full", action="store_true", help="16 houses, 8 for the curves: some hours")
    parser.add_argument("--houses", type=int, default=6)
    parser.add_argument(
        "--first", type=int, default=FIRST, help="number of the first house of the main table"
    )
    parser.add_argument("--only", default=",".join(SECTIONS))
    parser.add_argument("--oriented", type=Path, help="orientation/colmap of a run on the real models")
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "frontage-windows")
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--sheet", type=Path, help="folder for contact sheets")
    arguments = parser.parse_args()
    only = arguments.only.split(",")
    if arguments.quick:
        make = scenes(1, arguments.cache, gsd=0.008, views=3, most=2)
        compare("One house, two windows, 8 mm per px, 3 views", make, METHODS, arguments.sheet)
        return
    houses = 16 if arguments.full else arguments.houses
    if "main" in only:
        main_table(houses, arguments.cache, arguments.sheet, arguments.first)
    if "exact" in only:
        exact_table(houses, arguments.cache, arguments.first)
    if "speed" in only:
        speed(houses, arguments.cache)
    curves(8 if arguments.full else min(houses, 4), arguments.cache, only)
    if "scans" in only:
        scans(20 if arguments.full else max(len(SPACINGS), houses), arguments.cache)
    real(only, arguments.data, arguments.sheet, arguments.oriented)


if __name__ == "__main__":
    main()
