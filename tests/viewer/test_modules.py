"""The arithmetic of the viewer in the browser is that of the Python API."""

import base64
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from frontage.catalog.addresses import find_building
from frontage.errors import InputError
from frontage.geometry.arrays import Array
from frontage.queries.runfolder import open_run
from frontage.viewer.bands import BANDS, encoded
from frontage.viewer.facade import _ortho
from frontage.viewer.run import Run
from nodejs import call

ADDRESSES = {
    "B01": ["13 rue Soufflot"],
    "B02": ["13 bis rue Soufflot", "2 place du Panthéon"],
    "B03": ["Bahnhofstraße 7"],
    "B04": ["15-19 High Street"],
    "B05": [],
    "B06": ["15 avenue Foch, 75116 Paris"],
    "B07": ["Sankt-Anna-Straße 12b"],
    "B08": ["Haus am See"],
    "B09": ["221B Baker Street, London NW1 6XE"],
    "B10": ["rue Soufflot 15"],
}
ASKED = (
    """
13 rue soufflot|RUE SOUFFLOT 13|13bis, Rue Soufflot|13 ter rue Soufflot|rue Soufflot|17 High St|16 high street
bahnhofstr 7|Bahnhofstrasse 7|7|B05|b08|panthéon|2 pl. du Pantheon|am See|12 b st anna strasse|ß|Haus|15
12b Sankt Anna Straße|15 av Foch|15 Foch Paris|75116|221b baker st|nowhere||  |99 rue Soufflot|221 Baker
High Street 15-19|20 High Street
""".strip()
    .replace("\n", "|")
    .split("|")
)


def python_answer(asked: str, known: dict[str, list[str]]) -> str:
    try:
        return find_building(asked, known)
    except InputError as error:
        return "several" if "matches" in str(error) else "none"


def test_addresses_mean_the_same_buildings_as_in_python() -> None:
    words = ["13", "13 bis", "15-19", "7", "rue", "Soufflot", "Straße", "strasse", "St.", "High", "é", ","]
    asked = ASKED + [" ".join(pair) for pair in product(words, repeat=2)]
    known = [{"id": name, "addresses": own} for name, own in ADDRESSES.items()]
    found = call(
        "address.ts",
        "return given.asked.map((a) => m.meant(a, given.known))",
        {"asked": asked, "known": known},
    )
    told = [own[0] if len(own) == 1 else "several" if own else "none" for own in found]
    wanted = [python_answer(text, ADDRESSES) for text in asked]
    assert dict(zip(asked, told, strict=True)) == dict(zip(asked, wanted, strict=True))
    assert {"B01", "B02", "B03", "B04", "several", "none"} <= set(wanted)


def test_pixels_are_measured_as_in_python(simulated_run: Path) -> None:
    name = open_run(simulated_run).facades[0]
    pixels = open_run(simulated_run).facade(name)
    ortho = _ortho(Run(open_run(simulated_run).store), name)
    w, h = pixels.size
    asked = np.random.default_rng(1).uniform((0, 0), (w, h), (200, 2))
    wanted = [pixels.pixel_to_world(float(c), float(r)) for c, r in asked]
    assert {p.surface for p in wanted} == {"relief", "plane"}
    places = [
        [float(c), float(r), p.depth if p.surface == "relief" else None]
        for (c, r), p in zip(asked, wanted, strict=True)
    ]
    body = "return given.places.map(([c, r, y]) => m.worldFromPixel(given.ortho, c, r, y))"
    found = call("measure.ts", body, {"ortho": ortho, "places": places})
    assert np.allclose([p["xyz"] for p in found], [(p.x, p.y, p.z) for p in wanted], rtol=0, atol=1e-8)
    assert np.allclose([p["sigma"] for p in found], [p.sigma for p in wanted], rtol=1e-9)
    assert all(0 < p.sigma < 0.1 for p in wanted if p.sigma is not None)


def test_lengths_and_areas_on_the_wall_have_the_error_of_pixels() -> None:
    ortho = {"gsd": 0.01, "corner": [-3.0, 7.0]}
    path = [[100, 50], [400, 450], [400, 650]]
    body = "return [m.lengthOf(given.ortho, given.path), m.areaOf(given.ortho, given.path)]"
    length, area = call("measure.ts", body, {"ortho": ortho, "path": path})
    assert length["value"] == pytest.approx(5.0 + 2.0) and area["value"] == pytest.approx(0.5 * 2.0 * 3.0)
    rng = np.random.default_rng(2)
    moved = np.array(path) + rng.uniform(-0.5, 0.5, (20_000, 3, 2))
    lengths = np.linalg.norm(np.diff(moved, axis=1), axis=2).sum(1) * 0.01
    (x0, y0), (x1, y1), (x2, y2) = moved.transpose(1, 2, 0)
    areas = np.abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) / 2 * 1e-4
    assert length["sigma"] == pytest.approx(lengths.std(), rel=0.03)
    assert area["sigma"] == pytest.approx(areas.std(), rel=0.03)


@pytest.mark.parametrize("name", BANDS)
def test_bands_come_back_as_they_were(name: str) -> None:
    rng = np.random.default_rng(3)
    band = BANDS[name]
    values: Array = rng.integers(0, 9, (37, 53)).astype(np.uint16)
    values[5:9, 7:20] = 65535
    if band.unit:
        values = rng.normal(0.01, 0.4 if name == "depth" else 0.001, (37, 53)).astype(np.float32)
        values[3:7, 10:30] = np.nan
    about = {"unit": band.unit or 1, "bytes": np.dtype(band.dtype).itemsize, "missing": band.missing}
    body = """
        const data = Uint8Array.from(atob(given.data), (c) => c.charCodeAt(0)).buffer;
        return [...(await m.decode(data, given.about, 53, 37)).values];
    """
    data = base64.b64encode(encoded(values, band)).decode()
    found = np.array(call("decode.ts", body, {"data": data, "about": about})).reshape(37, 53)
    known = found != band.missing
    if not band.unit:
        assert (found == values).all()
        return
    assert (known == np.isfinite(values)).all()
    wanted = np.clip(values[known], 0 if band.dtype == "<u2" else -np.inf, None)
    assert np.abs(found[known] * band.unit - wanted).max() <= 0.5001 * band.unit


def test_fewer_pixels_are_drawn_while_a_slow_view_moves_and_all_when_it_rests() -> None:
    body = """
        const shares = [], pace = new m.Pace(() => shares.push(pace.scale));
        const run = (ms, frames) => {
            for (let k = 0; k < frames; k++) { pace.moved(); pace.frame(now); now += ms; }
            return pace.scale;
        };
        let now = 1;
        pace.frame(now); pace.frame(now += 500);
        const still = pace.scale;
        const fast = run(16, 20), slow = run(200, 6), medium = run(45, 6);
        await new Promise((done) => setTimeout(done, 400));
        return { still, fast, slow, medium, rest: pace.scale, told: shares.at(-1) };
    """
    found = call("scene/pace.ts", body, None)
    assert found["still"] == found["fast"] == 1.0
    assert found["slow"] == 0.3 and found["medium"] == 0.3, "it neither speeds up nor slows down"
    assert found["rest"] == found["told"] == 1.0
