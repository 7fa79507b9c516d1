"""The site of a run folder: what it holds, how it is served and exported."""

import http.client
import json
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from frontage.cli.main import main
from frontage.errors import FileError, InputError
from frontage.pipeline.store.store import Store
from frontage.queries.runfolder import open_run
from frontage.viewer import program
from frontage.viewer.export import export
from frontage.viewer.server import SiteServer
from frontage.viewer.site import Site, SiteFile, site_of


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program as if it were built."""
    folder = tmp_path / "program"
    folder.mkdir()
    (folder / "index.html").write_text("<!doctype html><title>Frontage</title>")
    monkeypatch.setattr(program, "_FOLDER", folder)
    return folder


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def told(site: Site, path: str) -> dict:
    return json.loads(site.files[path].read())


def test_the_overview_and_the_page_of_a_facade_tell_what_the_run_found(
    simulated_run: Path, built: Path
) -> None:
    run, site = open_run(simulated_run), site_of(Store(simulated_run))
    table = told(site, "run.json")
    assert table["name"] == "tiny", "the name of the project, not of the folder"
    assert [f["id"] for f in table["facades"]] == list(run.facades)
    assert table["tiles"]["path"] in site.files and table["left_out"] == []
    for entry in table["facades"]:
        elements = run.openings(entry["id"])
        assert elements is not None
        assert [o["id"] for o in entry["openings"]] == [o.id for o in elements.openings]
        page = told(site, f"{entry['path']}/facade.json")
        assert page["ortho"]["raster_to_world"] == run.facade(entry["id"]).raster_to_world.tolist()
        for opening in page["openings"]:
            found = run.locate(opening["id"])
            assert opening["center"] == list(found.center) and opening["depth"] == found.depth
            assert opening["sigma"] == found.sigma
            assert [(v["photo"], v["visible"]) for v in opening["photos"]] == [
                (v.photo, v.visible) for v in found.photos
            ]
            assert all(table["photos"][v["number"]]["id"] == v["photo"] for v in opening["photos"])


def test_a_poor_run_says_what_is_left_out(simulated_run: Path, built: Path, tmp_path: Path) -> None:
    out = tmp_path / "poor"
    shutil.copytree(simulated_run, out)
    shutil.rmtree(out / "products")
    for stage in ("ortho", "openings", "crossbars"):
        for marker in (out / ".done").glob(f"{stage}*"):
            marker.unlink()
    manifest = json.loads((out / "manifest.json").read_text())
    manifest["project"]["photos"] = None
    (out / "manifest.json").write_text(json.dumps(manifest))
    site = site_of(Store(out))
    table = told(site, "run.json")
    text = " ".join(table["left_out"])
    for words in (
        "no ortho-image, and so no picture, of: B01/F1",
        "Openings were not found on, or not looked for on: B01/F1",
        "no model",
        "no oriented photos",
    ):
        assert words in text
    entry = table["facades"][0]
    assert table["tiles"] is None and entry["ortho"] is None and entry["openings"] is None
    page = told(site, f"{entry['path']}/facade.json")
    assert page["ortho"] is None and page["openings"] is None
    assert not any(path.startswith(("photos/", "tiles/")) for path in site.files)


def test_a_folder_without_facades_and_a_missing_program_end_in_one_sentence(
    simulated_run: Path, built: Path, tmp_path: Path
) -> None:
    result = call("view", tmp_path)
    assert result.exit_code == 1 and "is not a run folder" in result.output
    bare = tmp_path / "bare"
    bare.mkdir()
    (bare / "manifest.json").write_text("{}")
    result = call("view", bare)
    assert result.exit_code == 1 and "has no facade that could be shown" in result.output
    (built / "index.html").unlink()
    result = call("view", simulated_run)
    assert result.exit_code == 1 and "build it with `make viewer`" in result.output
    assert "Traceback" not in result.output


def test_an_export_holds_the_site_and_replaces_only_an_earlier_one(
    simulated_run: Path, built: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "site"
    site = site_of(Store(simulated_run))
    result = call("view", simulated_run, "--export", folder, "--json")
    assert result.exit_code == 0, result.output
    made = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert made == set(site.files) and json.loads(result.stdout)["files"] == len(made)
    assert (folder / "run.json").read_bytes() == site.files["run.json"].read()
    (folder / "old.txt").write_text("from an earlier export")
    assert call("view", simulated_run, "--export", folder).exit_code == 0
    assert not (folder / "old.txt").exists()
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("do not delete")
    result = call("view", simulated_run, "--export", mine)
    assert result.exit_code == 1 and "is no earlier export" in result.output
    assert (mine / "thesis.txt").read_text() == "do not delete"
    assert {p.name for p in tmp_path.iterdir()} == {"site", "mine", "program"}


def test_an_export_leaves_out_what_cannot_be_read(tmp_path: Path) -> None:
    def fail() -> bytes:
        raise FileError("IMG_1.jpg", "no such file")

    def text() -> bytes:
        return b"{}"

    site = Site(
        {"run.json": SiteFile("", text), "index.html": SiteFile("", text), "p/1.jpg": SiteFile("", fail)}
    )
    made = export(site, tmp_path / "site")
    assert made.files == 2 and made.failed == ("IMG_1.jpg: no such file",)


@pytest.fixture
def server(simulated_run: Path, built: Path) -> Iterator[SiteServer]:
    with SiteServer(site_of(Store(simulated_run))) as found:
        threading.Thread(target=found.serve_forever, daemon=True).start()
        yield found
        found.shutdown()


def ask(server: SiteServer, path: str, method: str = "GET", **headers: str) -> tuple[int, bytes, str]:
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, answer.read(), answer.headers["Content-Type"]
    connection.close()
    return found


def test_the_server_answers_for_the_site_alone(server: SiteServer, simulated_run: Path) -> None:
    assert server.server_address[0] == "127.0.0.1"
    status, body, media = ask(server, "/")
    assert status == 200 and b"Frontage" in body and media.startswith("text/html")
    status, body, media = ask(server, "/run.json")
    assert status == 200 and json.loads(body)["facades"] and media.startswith("application/json")
    assert ask(server, "/run.json", "HEAD")[:2] == (200, b"")
    for path in (
        "/manifest.json", "/../manifest.json", "/%2e%2e/manifest.json", "/facades/B01_F1/../../manifest.json",
        "/facades/", "/facades/B01_F1", "/scans/cloud.npz", "//etc/passwd", "/a%00b",
        f"/{simulated_run}",
    ):  # fmt: skip
        assert ask(server, path)[0] == 404, path


def test_the_server_refuses_foreign_names_and_a_taken_port(server: SiteServer) -> None:
    assert ask(server, "/run.json", Host="evil.example")[0] == 403
    assert ask(server, "/run.json", Host=f"localhost:{server.server_port}")[0] == 200
    assert ask(server, "/run.json", "POST")[0] == 501
    with pytest.raises(InputError, match="cannot be used"):
        SiteServer(server.site, server.server_port)
