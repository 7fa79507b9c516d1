"""What `frontage simulate` writes: complete, true, repeatable."""

import hashlib
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from frontage.errors import FileError, OptionError, WorkspaceError
from frontage.evaluation.ortho import displacements
from frontage.evaluation.result import OrthoPair
from frontage.evaluation.truth import Truth, read_truth
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.citymodels.openings import read_city_openings
from frontage.io.geographic import latitude_longitude, true_heading
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.read import read_scans
from frontage.pipeline.project import load_project
from frontage.simulate.scene import Part
from frontage.simulate.sensors.recording import Echo
from frontage.simulate.spec import parse_spec
from frontage.studies.scenefolder import SceneFolder
from frontage.studies.simulate import simulate
from realdata import data_path
from simulated import BARE, truth_of


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(parse_spec(BARE), tmp_path_factory.mktemp("scenes") / "bare").out


@pytest.fixture(scope="module")
def truth(simulated: Path) -> Truth:
    return read_truth(truth_of(simulated))


def hashes(folder: Path) -> dict[str, str]:
    files = sorted(p for p in folder.rglob("*") if p.is_file())
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_the_same_spec_gives_the_same_bytes_at_any_number_of_workers(bare: Path, tmp_path: Path) -> None:
    again = simulate(parse_spec(BARE), tmp_path / "again", workers=2)
    assert hashes(again.out) == hashes(bare)
    other = simulate(parse_spec(BARE.replace("seed = 2", "seed = 3")), tmp_path / "other")
    assert hashes(other.out)["scans/S1.e57"] != hashes(bare)["scans/S1.e57"]


def test_every_file_is_listed_and_an_earlier_scene_is_replaced(bare: Path, tmp_path: Path) -> None:
    names = set(json.loads((bare / "truth" / "files.json").read_text())["files"])
    assert set(hashes(bare)) == names | {"truth/files.json"}
    out = tmp_path / "scene"
    simulate(parse_spec(BARE), out)
    parts = BARE.split("[[cameras]]")
    only_photos = parts[0].split("[[scanners]]")[0] + "[[cameras]]" + parts[1] + "[output]\ngsd = 0.1\n"
    (out / "mine.txt").write_text("kept")
    simulate(parse_spec(only_photos), out)
    left = set(hashes(out))
    assert "mine.txt" in left and "photos/IMG_0001.jpg" in left
    assert not any(name.startswith("scans/") for name in left)


def test_a_finished_scene_is_kept_and_a_damaged_one_made_again(bare: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(bare, tmp_path / "scene"))
    before = {p: p.stat().st_mtime_ns for p in out.rglob("*") if p.is_file()}
    kept = simulate(parse_spec(BARE), out)
    assert not any("simulated again" in note for note in kept.notes)
    assert {p: p.stat().st_mtime_ns for p in out.rglob("*") if p.is_file()} == before
    assert kept.photos == 2 and kept.points > 1000
    (out / "scans" / "S1.e57").unlink()
    again = simulate(parse_spec(BARE), out)
    assert again.notes[0].endswith("is simulated again, because scans/S1.e57 is missing")
    assert hashes(out) == hashes(bare)


def test_a_scene_that_is_made_again_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = {"the simulator": "1", "the spec": "2"}
    folder = SceneFolder(tmp_path, made)
    assert not folder.current() and folder.outdated() == ""
    folder.begin(["a.txt"])
    assert SceneFolder(tmp_path, made).outdated() == "it was not finished"
    (tmp_path / "a.txt").write_text("a")
    folder.finish()
    assert SceneFolder(tmp_path, made).current()
    other = SceneFolder(tmp_path, {"the simulator": "2", "the spec": "3"})
    assert not other.current() and other.outdated() == "the simulator and the spec changed"
    table = json.loads((tmp_path / "truth" / "files.json").read_text())
    del table["made_of"]  # as an earlier version left it
    (tmp_path / "truth" / "files.json").write_text(json.dumps(table))
    assert "the simulator" in SceneFolder(tmp_path, made).outdated()


def test_a_folder_with_other_things_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear reader")
    with pytest.raises(WorkspaceError, match="not empty"):
        simulate(parse_spec(BARE), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["letter.txt"]
    with pytest.raises(WorkspaceError, match="is a file"):
        simulate(parse_spec(BARE), tmp_path / "letter.txt")


def test_a_street_without_houses_cannot_be_measured(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="no houses"):
        simulate(parse_spec("houses = 0\n[[scanners]]\nstations = 1\n"), tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_scans_are_read_back_where_the_truth_has_them(simulated: Path, truth: Truth) -> None:
    table = truth_of(simulated)
    (facade,) = [f for f in truth.facades if f.visible["stations"] > 0.5]
    assert len(table["stations"]) == 2
    for entry in table["stations"]:
        (scan,) = read_scans(simulated / entry["file"], truth.world)
        arrays = np.load(simulated / "truth" / f"points_{Path(entry['file']).stem}.npz")
        assert len(scan) == entry["points"] == len(arrays["surface"])
        assert (scan.grid.index < 0).any()
        assert np.abs(scan.origins[0] + truth.world.origin - entry["true"]["position"]).max() < 1e-5
        wall = (arrays["part"] == Part.WALL) & (arrays["echo"] == Echo.PLAIN)
        local = facade.frame.inverse.apply(scan.xyz[wall])
        front = np.abs(local[:, 1]) < 0.05
        assert front.sum() > 5000 and abs(local[front, 1].mean()) < 0.002
        assert (facade.outline.min(0) - 0.1 < local[front][:, [0, 2]].min(0)).all()


@pytest.mark.parametrize("kind", ["ptx", "laz"])
def test_other_formats_hold_the_same_points(bare: Path, tmp_path: Path, kind: str) -> None:
    text = BARE.replace("[output]", f'[output]\nscans = "{kind}"').split("[drive]")[0]
    out = simulate(parse_spec(text + f'[output]\nscans = "{kind}"\ngsd = 0.1\n'), tmp_path / kind).out
    sources = load_project(out / "project.toml").scans
    assert len(sources) == 2
    for source in sources:
        (scan,) = read_scans(source)
        (reference,) = read_scans(bare / "scans" / (Path(source.path).stem + ".e57"))
        assert len(scan) == len(reference)
        gaps = scan.world.to_world(scan.xyz) - reference.world.to_world(reference.xyz)
        assert np.abs(gaps).max() < 2e-4


def test_the_mobile_recording_has_its_trajectory_and_truth(bare: Path) -> None:
    table = truth_of(bare)
    source = load_project(bare / "project.toml").scans[-1]
    (scan,) = read_scans(source)
    arrays = np.load(bare / "truth" / "points_mobile.npz")
    assert len(scan) == table["drive"]["points"] == len(arrays["surface"])
    assert (scan.origin_index >= 0).all() and scan.time is not None
    distance = np.linalg.norm(scan.xyz - scan.origins[scan.origin_index], axis=1)
    assert np.median(np.abs(distance - arrays["range"])) < 0.3  # origins are the vehicle's, not the scanners'


def test_photos_show_the_facade_where_the_truth_has_it(simulated: Path, truth: Truth) -> None:
    """The true ortho-image seen through a photo's true pose: both agree to a twentieth of a pixel."""
    cameras = str(simulated / "cameras")
    source = PhotoSource(
        path=str(simulated / "photos" / "*.jpg"), cameras=cameras, offset=tuple(truth.world.origin.tolist())
    )
    photos = read_photos(source, truth.world)
    (facade,) = [f for f in truth.facades if f.ortho]
    about = facade.ortho
    true = cv2.imread(str(simulated / about["file"]))[..., ::-1]
    opening = cv2.imread(str(simulated / about["ids"]), cv2.IMREAD_UNCHANGED)
    depth = np.load(simulated / about["arrays"])["depth"].astype(float)
    h, w = depth.shape
    x = about["corner"][0] + (np.arange(w) + 0.5) * about["gsd"]
    z = about["corner"][1] - (np.arange(h) + 0.5) * about["gsd"]
    X, Z = np.meshgrid(x, z)
    local = facade.frame.apply(np.column_stack([X.ravel(), np.nan_to_num(depth).ravel(), Z.ravel()]))
    assert len(photos.photos) == 2
    for photo in photos.photos:
        uv = np.nan_to_num(photo.project(local), nan=-99.0).clip(-99, 9999).astype(np.float32) - 0.5
        column, row = uv.T.reshape(2, h, w)
        seen = cv2.remap(photos.image(photo.id), column, row, cv2.INTER_CUBIC)
        valid = (column > 1) & (column < 718) & (row > 1) & (row < 718) & np.isfinite(depth)
        pair = OrthoPair(facade.id, true, seen, valid, opening, about["gsd"], about["gsd"], depth)
        shifts, _ = displacements(pair)
        assert len(shifts) > 10
        assert np.abs(np.median(shifts, axis=0)).max() < 0.05


def test_exif_tells_the_approximate_pose(simulated: Path, truth: Truth) -> None:
    from frontage.io.photos.imagefile import image_header

    entry = truth_of(simulated)["photos"][0]
    header = image_header(simulated / "photos" / entry["name"])
    assert (header.width, header.height) == (entry["camera"]["width"], entry["camera"]["height"])
    true, given = (np.array(entry[k]["center"]) for k in ("true", "given"))
    assert 0.01 < np.linalg.norm(true - given) < 12
    ((latitude, longitude),) = latitude_longitude(given[None, :2], truth.world.crs)
    assert b"Exif" in (simulated / "photos" / entry["name"]).read_bytes()[:64]
    assert 47 < latitude < 49 and 11 < longitude < 13
    view = np.array(entry["true"]["R"])[2]
    grid = np.degrees(np.arctan2(view[0], view[1])) % 360
    turned = (true_heading(given, view, truth.world.crs) - grid + 180) % 360 - 180
    assert 0.5 < abs(turned) < 3  # the grid's north is not the true one, nor far from it


def test_visibility_tells_the_front_from_the_back(truth: Truth) -> None:
    front = max(truth.facades, key=lambda f: f.visible["any"])
    assert front.id == "B01/F1" and front.visible["stations"] > 0.7
    assert sum(f.visible["any"] == 0 for f in truth.facades) >= 1
    windows = [o for o in front.openings if o.kind == "window"]
    assert np.mean([o.visible["any"] for o in windows]) > 0.8
    assert all(o.visible["any"] >= max(o.visible["stations"], o.visible["photos"]) for o in windows)


def test_city_models_hold_the_houses_and_their_openings(simulated: Path, truth: Truth) -> None:
    table = truth_of(simulated)
    for name in ("lod2.city.json", "lod2.gml"):
        (footprint,) = read_footprints(simulated / name, truth.world)
        assert footprint.address == table["buildings"][0]["address"]
        offset = footprint.ring.mean(0) - truth.buildings[0].footprint.mean(0)
        assert np.abs(offset - table["lod2"]["shift"][:2]).max() < 0.5
    openings = read_city_openings(simulated / table["lod3"])
    assert {o.about["id"] for o in openings} == {o.id for f in truth.facades for o in f.openings}


def test_city_models_are_valid_by_their_schemas(simulated: Path) -> None:
    import jsonschema
    from lxml import etree

    schema = json.loads(data_path("schemas/cityjson/cityjson.min.schema.json").read_text())
    for name in ("lod2.city.json", "truth/lod3.city.json"):
        jsonschema.validate(json.loads((simulated / name).read_text()), schema)
    xsd = etree.XMLSchema(etree.parse(str(data_path("schemas/citygml/citygml/2.0/building.xsd"))))
    xsd.assertValid(etree.parse(str(simulated / "lod2.gml")))


def test_true_solids_are_closed(simulated: Path) -> None:
    model = json.loads((simulated / "truth" / "lod3.city.json").read_text())
    assert len(model["CityObjects"]) == 1
    for building in model["CityObjects"].values():
        edges: list[tuple[int, int]] = []
        for rings in building["geometry"][0]["boundaries"][0]:
            for ring in rings:
                edges += list(zip(ring, ring[1:] + ring[:1], strict=True))
        assert len(edges) == len(set(edges)) > 100
        assert {(b, a) for a, b in edges} == set(edges)


LOD3 = """
seed = 2
from_model = "models/house.city.json"
trees = 0
cars = 0
people = 0
lamps = 0
[[scanners]]
stations = 1
spacing = 0.1
field = 150
lowest = -15
highest = 40
subrays = 1
[[cameras]]
width = 120
height = 90
most = 1
samples = 1
[output]
gsd = 0.05
"""


def test_a_scene_from_a_city_model_has_its_openings_and_its_world(bare: Path, tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    shutil.copy(bare / "truth" / "lod3.city.json", tmp_path / "models" / "house.city.json")
    with pytest.raises(FileError, match="no such file"):
        simulate(parse_spec(LOD3), tmp_path / "scene")
    out = simulate(parse_spec(LOD3), tmp_path / "scene", base=tmp_path).out
    table, source = truth_of(out), truth_of(bare)
    assert table["crs"] == source["crs"]
    made, wanted = (
        [np.mean(o["outline_world"], axis=0) for f in t["facades"] for o in f["openings"]]
        for t in (table, source)
    )
    gaps = np.linalg.norm(np.array(made)[:, None] - np.array(wanted)[None], axis=2)
    assert len(made) == len(wanted) and gaps.min(0).max() < 0.01
    # a station before the longest facade sees it, and the ortho-image is there
    seen = [f for f in table["facades"] if f["visible"]["stations"] > 0.5]
    assert seen and all((out / f["ortho"]["file"]).exists() for f in seen)
    assert json.loads((out / "truth" / "spec.json").read_text())["from_model"] == ["models/house.city.json"]
    again = simulate(parse_spec(LOD3), tmp_path / "again", base=tmp_path, workers=2).out
    assert hashes(again) == hashes(out)
