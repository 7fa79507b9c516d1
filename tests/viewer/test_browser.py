"""The viewer in a browser: the exported site of a small run, served as any web server would."""

import json
import re
import shutil
import threading
import time
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

from frontage.errors import FrontageError
from frontage.pipeline.store.store import Store
from frontage.queries.runfolder import RunFolder, open_run
from frontage.viewer.export import export
from frontage.viewer.program import program_files
from frontage.viewer.site import site_of

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
CHROMIUM = next((found for name in NAMES if (found := shutil.which(name))), None)
ARGUMENTS = [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
]  # fmt: skip
EXPECTED = "tiles versions at 1.1 or higher have limited support"  # a warning of the tiles' renderer
PATIENCE_MS = 120_000  # a loaded machine draws slowly


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        pass


@pytest.fixture(scope="module")
def address(simulated_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    try:
        program_files()
    except FrontageError as error:
        pytest.skip(str(error))
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine")
    folder = tmp_path_factory.mktemp("export") / "site"
    assert not export(site_of(Store(simulated_run)), folder).failed
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder)) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture(scope="module")
def browser(address: str) -> Iterator[Browser]:
    with sync_playwright() as driver:
        found = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield found
        found.close()


@pytest.fixture
def page(browser: Browser, address: str) -> Iterator[Page]:
    """A page that may not complain, and asks nobody but the site."""
    yield from opened(browser, address, {"width": 1280, "height": 800})


def opened(browser: Browser, address: str, size: dict[str, int], **about: Any) -> Iterator[Page]:
    context = browser.new_context(viewport=size, **about)
    found = context.new_page()
    found.set_default_timeout(PATIENCE_MS)
    said: list[str] = []
    found.on(
        "console", lambda m: m.type in ("error", "warning") and EXPECTED not in m.text and said.append(m.text)
    )
    found.on("pageerror", lambda error: said.append(str(error)))
    found.on("requestfailed", lambda r: said.append(f"failed: {r.url}"))
    found.on("request", lambda r: r.url.startswith((address, "blob:", "data:")) or said.append(r.url))
    found.goto(address)
    found.wait_for_selector(".list .facade-row")
    yield found
    context.close()
    assert not [text for text in said if "GL Driver Message" not in text]


@pytest.fixture(scope="module")
def run(simulated_run: Path) -> RunFolder:
    return open_run(simulated_run)


def becomes(page: Page, expression: str, given: Any, seconds: float) -> bool:
    """Whether JavaScript becomes true in time. The page's own rules let nothing evaluate text inside it."""
    end = time.monotonic() + seconds
    while not page.evaluate(expression, given):
        if time.monotonic() > end:
            return False
        page.wait_for_timeout(50)
    return True


def until(page: Page, expression: str, given: Any = None) -> None:
    """Wait until JavaScript is true."""
    assert becomes(page, expression, given, PATIENCE_MS / 1000), f"never true: {expression}"


def front(run: RunFolder) -> str:
    return max(run.facades, key=lambda name: len(run.openings(name).openings))


def open_facade(page: Page, name: str) -> None:
    page.goto(f"{page.url.split('#')[0]}#/{name}")
    page.wait_for_selector(".facade canvas")
    until(page, "frontage.page?.view?.view.scale !== 1")


def click(page: Page, at: tuple[float, float]) -> list[float]:
    """Click at a share of the canvas; return the pixel of the ortho-image that is there."""
    box = page.locator(".facade canvas").bounding_box()
    assert box is not None
    x, y = (round(box[side] * share) for side, share in zip(("width", "height"), at, strict=True))
    pixel: list[float] = page.evaluate("(at) => frontage.page.view.view.toPicture(at)", [x, y])
    page.mouse.click(box["x"] + x, box["y"] + y)
    return pixel


def clicked(page: Page, at: tuple[float, float]) -> tuple[list[float], list[float], float | None]:
    """Click at a share of the canvas; return the pixel of the ortho-image, and the place and sigma shown.

    Clicks again where the canvas moved between the look at it and the click, as it may while a page loads.
    """
    told = (
        "([c, r]) => { const p = frontage.page.view.probeAt([c, r], true); "
        "const shown = document.querySelector('.readout').dataset.xyz; "
        "return p && shown === p.world.xyz.map((v) => v.toFixed(4)).join(' '); }"
    )
    end = time.monotonic() + PATIENCE_MS / 1000
    pixel = click(page, at)
    while not becomes(page, told, pixel, 10.0):
        assert time.monotonic() < end, f"never told: the place of {pixel}"
        pixel = click(page, at)
    shown = page.locator(".readout").evaluate("(e) => [e.dataset.xyz, e.dataset.sigma]")
    sigma = None if shown[1] == "null" else float(shown[1])
    return pixel, [float(v) for v in shown[0].split()], sigma


def test_a_click_gives_the_coordinates_of_the_python_api(page: Page, run: RunFolder) -> None:
    name = front(run)
    open_facade(page, name)
    pixels, surfaces = run.facade(name), set()
    for at in ((0.5, 0.5), (0.42, 0.3), (0.61, 0.66), (0.37, 0.55), (0.55, 0.4)):
        (column, row), xyz, sigma = clicked(page, at)
        wanted = pixels.pixel_to_world(column, row)
        surfaces.add(wanted.surface)
        assert np.abs(np.array(xyz) - (wanted.x, wanted.y, wanted.z)).max() <= 1e-4
        assert sigma == pytest.approx(wanted.sigma)
    assert "relief" in surfaces
    # Far in, at the scale of pixels, it still does.
    page.evaluate("() => { frontage.page.view.view.zoom(20); frontage.page.view.redraw(); }")
    (column, row), xyz, _ = clicked(page, (0.52, 0.47))
    wanted = pixels.pixel_to_world(column, row)
    assert np.abs(np.array(xyz) - (wanted.x, wanted.y, wanted.z)).max() <= 1e-4


def test_a_search_finds_what_locate_finds(page: Page, run: RunFolder) -> None:
    addresses = {r.id: r.address for r in run.store.building_records()}
    name = front(run)
    asked = addresses[name.rsplit("/", 1)[0]] or name.rsplit("/", 1)[0]
    elements = run.openings(name)
    assert elements is not None and elements.openings
    search = page.locator(".search input")
    for opening in (elements.openings[0], elements.openings[-1]):
        found = run.locate(asked, floor=opening.floor, window=opening.number)
        search.fill(f"{asked.upper()}, floor {opening.floor}, window {opening.number}")
        search.press("Enter")
        page.wait_for_selector(f'.panel[aria-label="{found.id}"]')
        assert page.url.endswith(f"#/{found.id}")
        text = page.locator(".panel").inner_text()
        assert f"{found.width:.3f} × {found.height:.3f} m" in text
        assert " ".join(f"{v:.3f}" for v in found.center) in text
        rows = page.locator(".panel table").first.locator("tr").all_inner_texts()
        assert [re.findall(r"[\d.]+", row) for row in rows] == [
            [f"{v:.3f}" for v in c] for c in found.corners
        ]
        assert page.locator(".photo").count() == len(found.photos)
    search.fill(f"{asked}, floor 99, window 1")
    search.press("Enter")
    assert "has no opening 1 on floor 99" in page.locator(".search .problem").inner_text()
    search.fill("nowhere at all, floor 1, window 1")
    search.press("Enter")
    assert "No building has the address" in page.locator(".search .problem").inner_text()


def test_the_district_shows_the_tiles_and_a_click_opens_a_facade(page: Page, run: RunFolder) -> None:
    page.wait_for_selector(".district canvas")
    until(page, "frontage.district.then((d) => d.model.tiles.visibleTiles.size > 0)")
    name = front(run)
    at = page.evaluate(
        """(id) => frontage.district.then((d) => {
            const f = frontage.run.facades.find((f) => f.id === id), c = d.camera;
            const p = c.position.clone().set(...f.center).project(c);
            const box = document.querySelector(".district canvas").getBoundingClientRect();
            return [box.left + (p.x + 1) / 2 * box.width, box.top + (1 - p.y) / 2 * box.height];
        })""",
        name,
    )
    # What is drawn there is the wall, not the sky or the ground.
    drawn = picture(page)[round(at[1]) - 10 : round(at[1]) + 10, round(at[0]) - 10 : round(at[0]) + 10]
    ground = picture(page)[-30:-20, 500:520]
    assert np.abs(drawn.mean((0, 1)) - ground.mean((0, 1))).max() > 8
    page.click("text=Before / after")
    until(page, "frontage.district.then((d) => d.before.scene.children.length > 2)")
    page.click("text=Before / after")
    page.mouse.move(*at)
    page.wait_for_selector(".tip:not([hidden])")
    assert name in page.locator(".tip").inner_text()
    page.mouse.click(*at)
    page.wait_for_selector(".facade canvas")
    assert f"#/{name}" in page.url


def test_the_tiles_stand_where_the_model_stands(page: Page, simulated_run: Path) -> None:
    model = json.loads((simulated_run / "model" / "lod3.city.json").read_text())
    origin = open_run(simulated_run).store.world().origin
    scale, shift = model["transform"]["scale"], model["transform"]["translate"]
    wanted = np.array(model["vertices"]) * scale + shift - origin
    until(page, "frontage.district && frontage.district.then((d) => d.model.tiles.visibleTiles.size > 0)")
    corners = page.evaluate(
        """frontage.district.then((d) => {
            const at = d.camera.position.clone(), low = [1e9, 1e9, 1e9], high = [-1e9, -1e9, -1e9];
            d.model.tiles.group.traverse((part) => {
                const positions = part.geometry?.attributes.position;
                for (let k = 0; k < (positions?.count ?? 0); k++) {
                    at.fromBufferAttribute(positions, k).applyMatrix4(part.matrixWorld).toArray()
                        .forEach((v, j) => { low[j] = Math.min(low[j], v); high[j] = Math.max(high[j], v); });
                }
            });
            return [low, high];
        })"""
    )
    found = np.array(corners)
    coarse = "the coarse model lacks balconies and steps"
    assert np.abs(found - [wanted.min(0), wanted.max(0)]).max() < 1.5, coarse
    assert np.abs(found[1, 2] - wanted[:, 2].max()) < 0.02  # the ridge is in both


def test_fingers_pan_and_pinch(browser: Browser, address: str, run: RunFolder) -> None:
    for page in opened(browser, address, {"width": 390, "height": 820}, has_touch=True):
        open_facade(page, front(run))
        box = page.locator(".facade canvas").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        state = "(() => { const v = frontage.page.view.view; return [v.scale, v.x, v.y]; })()"
        before = page.evaluate(state)
        fingers = page.context.new_cdp_session(page)

        def touch(kind: str, *places: tuple[float, float], to: CDPSession = fingers) -> None:
            points = [{"x": u, "y": v, "id": k} for k, (u, v) in enumerate(places)]
            to.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        touch("touchStart", (x, y))
        touch("touchMove", (x + 20, y + 10))
        touch("touchMove", (x + 40, y + 30))
        touch("touchEnd")
        panned = page.evaluate(state)
        assert panned[0] == before[0] and panned[1] > before[1] + 15 and panned[2] > before[2] + 10
        touch("touchStart", (x - 30, y), (x + 30, y))
        touch("touchMove", (x - 60, y), (x + 60, y))
        touch("touchEnd")
        assert page.evaluate(state)[0] == pytest.approx(2 * before[0], rel=0.05)
        assert page.locator(".panel").count() == 0  # that was no click


def test_distances_filters_layers_and_keys(page: Page, run: RunFolder) -> None:
    name = front(run)
    open_facade(page, name)
    page.keyboard.press("m")
    box = page.locator(".facade canvas").bounding_box()
    assert box is not None
    places = [(0.35, 0.5), (0.6, 0.5)]
    for x, y in places:
        page.mouse.click(box["x"] + round(box["width"] * x), box["y"] + round(box["height"] * y))
    page.keyboard.press("Enter")
    scale, gsd = page.evaluate("[frontage.page.view.view.scale, frontage.page.facade.ortho.gsd]")
    wanted = (round(box["width"] * 0.6) - round(box["width"] * 0.35)) / scale * gsd
    found = re.match(r"([\d.]+) m ± ([\d.]+) mm on the wall", page.locator(".result").inner_text())
    assert found is not None and float(found[1]) == pytest.approx(wanted, abs=0.002)
    page.keyboard.press("v")
    page.click(".layers summary")
    for layer in ("depth", "sources", "resolution", "evidence"):
        page.select_option(".layers select", layer)
        until(page, "(l) => !document.querySelector('.legend').hidden", layer)
    page.keyboard.press("/")
    assert page.evaluate("document.activeElement.type") == "search"
    elements = run.openings(name)
    assert elements is not None
    kind = str(elements.openings[0].kind)
    page.select_option(".filters select >> nth=0", kind)
    same = [o.id for f in run.facades for o in run.openings(f).openings if str(o.kind) == kind]
    assert page.locator(".opening-row").count() == len(same)
    page.locator(".opening-row").first.click()
    page.wait_for_selector(".panel")


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (1280, True), (390, False)])
def test_it_fits_the_screen_and_its_colours(
    browser: Browser, address: str, run: RunFolder, width: int, dark: bool
) -> None:
    scheme = "dark" if dark else "light"
    for page in opened(browser, address, {"width": width, "height": 820}, color_scheme=scheme):
        open_facade(page, front(run))
        page.locator(".opening-row").first.click()
        page.wait_for_selector(".panel")
        page.wait_for_timeout(500)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        image = picture(page)
        assert image.shape[1] == width
        head = np.median(image[4:8], axis=(0, 1)).mean()
        assert head < 60 if dark else head > 230
        canvas = page.locator(".facade canvas").bounding_box()
        assert canvas is not None and canvas["width"] > 0.4 * width and canvas["height"] > 250


def picture(page: Page) -> np.ndarray:
    found = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    assert found is not None
    return found.astype(float)
