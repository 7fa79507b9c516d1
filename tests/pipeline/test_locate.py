"""Where is the second window of the first floor: answers against the truth, sentences where there is none."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from frontage.catalog.sightlines import photo_views, scanned_surfaces
from frontage.cli.main import main
from frontage.errors import InputError, WorkspaceError
from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model import Elements, Estimate, Opening, Protrusion, Provenance
from frontage.pipeline.progress import Silent
from frontage.pipeline.project import load_project
from frontage.pipeline.run import run
from frontage.pipeline.store.elements import load_elements, save_product
from frontage.pipeline.store.store import Store
from frontage.queries.answer import Located
from frontage.queries.runfolder import RunFolder, open_run


@pytest.fixture
def copy(simulated_run: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(simulated_run, tmp_path / "copy"))


@pytest.fixture(scope="module")
def answers(simulated_run: Path) -> list[Located]:
    """Every opening of the tiny scene, asked for by its id."""
    store = Store(simulated_run)
    (name,) = store.facade_ids("openings")
    found = load_elements(store.facade_folder(name), name)
    return [open_run(simulated_run).locate(o.id) for o in found.openings]


@pytest.fixture(scope="module")
def truth(simulated: Path) -> list[dict[str, Any]]:
    table = json.loads((simulated / "truth" / "truth.json").read_text())
    return [o for facade in table["facades"] for o in facade["openings"]]


class _Told(Silent):
    """Remembers which stages were kept."""

    def __init__(self) -> None:
        self.kept: dict[str, bool] = {}

    def end(self, stage: str, seconds: float, kept: bool, items: int) -> None:
        self.kept[stage] = kept


def box(outline: Any) -> Float:
    p = np.array(outline)
    return np.concatenate([p.min(0), p.max(0)])


def nearest(found: Located, truth: list[dict[str, Any]]) -> dict[str, Any]:
    return min(truth, key=lambda o: float(np.abs(box(o["outline_world"]) - box(found.outline)).max()))


def told(copy: Path, addresses: Any) -> RunFolder:
    """The run folder with addresses in its project, as `frontage run` leaves them."""
    path = copy / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["project"]["addresses"] = addresses
    path.write_text(json.dumps(manifest))
    return open_run(copy)


def save(store: Store, facade: str, elements: Elements) -> None:
    """Other openings than were found, as the stages leave them."""
    store.save_found_elements(store.facade(facade), elements)
    save_product(store.facade_folder(facade), store.facade(facade), elements)


def test_floors_and_places_are_the_true_ones(answers: list[Located], truth: list[dict[str, Any]]) -> None:
    close = 0
    for found in answers:
        true = nearest(found, truth)
        off = np.abs(box(true["outline_world"]) - box(found.outline)).max()
        if off < 0.15:  # the same opening, well found
            close += 1
            assert found.floor == true["floor"]
            assert found.width == pytest.approx(np.ptp(np.array(true["outline"])[:, 0]), abs=0.1)
    assert close >= 4
    for floor in {found.floor for found in answers}:
        row = [(nearest(found, truth)["outline"], found.number) for found in answers if found.floor == floor]
        numbers = [number for _, number in sorted(row, key=lambda pair: float(np.mean(pair[0], axis=0)[0]))]
        assert numbers == sorted(set(numbers)) and numbers[0] >= 1  # from the left, each only once
    assert len(answers) > len({found.floor for found in answers})


def test_an_answer_agrees_with_itself_and_with_the_picture(
    answers: list[Located], simulated_run: Path
) -> None:
    found = next(a for a in answers if a.depth is not None)
    corners, outline = np.array(found.corners), np.array(found.outline)
    assert np.linalg.norm(corners[1] - corners[0]) == pytest.approx(found.width, abs=1e-3)
    assert np.linalg.norm(corners[3] - corners[0]) == pytest.approx(found.height, abs=1e-3)
    assert np.allclose(corners.mean(0), found.center, atol=1e-3)
    assert outline[:, 2].min() == pytest.approx(corners[:, 2].min(), abs=1e-3)
    assert found.corners_inside is not None and found.depth is not None
    assert np.allclose(
        np.linalg.norm(np.array(found.corners_inside) - corners, axis=1), abs(found.depth), atol=1e-3
    )
    assert 0 < found.area <= found.width * found.height * 1.001
    assert set(found.sigma) == {"left", "right", "bottom", "top", "width", "height", "depth", "plane"}
    pixels = open_run(simulated_run).facade(found.facade)
    assert found.pixels is not None
    upper_left = pixels.world_to_pixel(*found.corners[3])
    assert found.pixels[:2] == pytest.approx((upper_left.column, upper_left.row), abs=0.02)
    assert found.pixels[0] < found.pixels[2] and found.pixels[1] < found.pixels[3]
    assert pixels.crs == found.crs


def test_photos_show_the_opening_where_they_say(answers: list[Located], truth: list[dict[str, Any]]) -> None:
    assert sum(bool(a.photos) for a in answers) >= 2
    for found in answers:
        for view in found.photos:
            assert view.photo.endswith(".jpg") and 0.5 <= view.visible <= 1 and 0 <= view.angle < 90
            u, v = np.array(view.outline).T
            across = np.hypot(u.max() - u.min(), v.max() - v.min()) * view.gsd
            assert 0.5 < across / np.hypot(found.width, found.height) < 1.5
        if nearest(found, truth)["visible"]["photos"] < 0.3:
            assert not found.photos


@pytest.mark.parametrize("asked", ["13 rue Soufflot", "rue soufflot, 13", "B01", "B01/F1"])
def test_the_question_of_the_paper(copy: Path, asked: str, answers: list[Located]) -> None:
    wanted = next(a for a in answers if a.floor == 1 and a.number == 2)
    store = told(copy, {"B01": "13 rue Soufflot"})
    found = store.locate(asked, floor=1, window=2)
    assert (found.id, found.outline, found.pixels) == (wanted.id, wanted.outline, wanted.pixels)
    assert found.address == (asked if "ouf" in asked else None)
    assert found.chosen == ("asked for" if asked == "B01/F1" else "the only one of the building")


def test_the_facade_with_the_most_openings_is_meant_unless_another_is_asked_for(copy: Path) -> None:
    store = Store(copy)
    for stage in ("facades", "ortho", "openings", "crossbars"):
        path = copy / ".done" / f"{stage}.B01.json"
        marker = json.loads(path.read_text())
        marker["result"]["facades"] = ["B01/F1", "B01/F2"]
        path.write_text(json.dumps(marker))
    shutil.copytree(copy / "facades" / "B01_F1", copy / "facades" / "B01_F2")
    folder = store.facade_folder("B01/F1")
    save(store, "B01/F1", Elements("B01/F1", load_elements(folder, "B01/F1").openings[-1:]))
    found = open_run(copy).locate("B01", floor=0, window=1)
    assert found.facade == "B01/F2" and found.chosen == "the one with the most openings, before B01/F1"
    with pytest.raises(InputError, match="B01/F1 has no opening 1 on floor 0"):
        open_run(copy).locate("B01", floor=0, window=1, facade="f1")


def test_addresses_are_told_without_measuring_anything_again(copy: Path, simulated: Path) -> None:
    project = load_project(
        simulated / "project.toml", {"addresses": {"B01": ["13 rue Soufflot", "2 Hofgasse"]}}
    )
    told = _Told()
    run(project, copy, progress=told)
    again = {stage for stage, kept in told.kept.items() if not kept}
    assert "model" in again and again <= {"model", "export", "tables", "elevations", "bim", "qgis", "report"}
    for asked in ("13 rue Soufflot", "hofgasse 2"):
        assert open_run(copy).locate(asked, floor=1, window=1).building == "B01"


def test_openings_name_the_photos_that_show_them(answers: list[Located], simulated_run: Path) -> None:
    folder = Store(simulated_run).facade_folder("B01/F1")
    found = {o.id: o.photos for o in load_elements(folder, "B01/F1").openings}
    assert found == {a.id: tuple(view.photo for view in a.photos) for a in answers}
    assert any(found.values())


def test_an_address_by_a_point_follows_the_house(copy: Path, answers: list[Located]) -> None:
    x, y, _ = answers[0].center
    store = told(copy, [{"address": "13 rue Soufflot", "at": [x, y]}])
    assert (
        store.locate("13 rue Soufflot", floor=answers[0].floor, window=answers[0].number).id == answers[0].id
    )
    store = told(copy, [{"address": "13 rue Soufflot", "at": [x + 500, y]}])
    with pytest.raises(InputError, match=r"where no building stands; the nearest, B01, is \d+ m away"):
        store.locate("13 rue Soufflot", floor=1, window=2)


def test_an_address_of_no_building_says_so_only_when_asked_for(copy: Path, answers: list[Located]) -> None:
    store = told(copy, {"B01": "13 rue Soufflot", "B99": "15 rue Soufflot"})
    assert store.locate("13 rue Soufflot", floor=answers[0].floor, window=answers[0].number)
    with pytest.raises(InputError, match='gives "15 rue Soufflot" to building "B99", but the run has B01'):
        store.locate("15 rue Soufflot", floor=1, window=2)


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"address": "B01"}, "give --floor and one of"),
        ({"address": "B01", "floor": 1}, "give --floor and one of"),
        ({"address": "B01", "floor": 1, "window": 1, "door": 1}, "give --floor and one of"),
        ({"address": "B01/F1/W1-1", "floor": 1}, "is an opening's id: give it alone"),
        ({"address": "B01/F1/W1-77"}, "no opening B01/F1/W1-77; there, from the left: W1-1"),
        ({"address": "B01/F7/W1-1"}, "no facade .B01/F7. in .*; known: B01/F1"),
        (
            {"address": "B01", "floor": 1, "window": 77},
            "no opening 77 on floor 1; there, from the left: W1-1",
        ),
        ({"address": "B01", "floor": 1, "door": 77}, "no door 77 on floor 1"),
        ({"address": "B01", "floor": 9, "window": 1}, "openings were found on floors .*0, 1"),
        ({"address": "B01", "floor": 1, "window": 1, "facade": "F8"}, "B01 has no facade F8; it has B01/F1"),
        ({"address": "7 Nowhere", "floor": 1, "window": 1}, "no building has the"),
    ],
)
def test_what_is_not_there_is_told_in_a_sentence(
    simulated_run: Path, asked: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence) as error:
        open_run(simulated_run).locate(**asked)
    assert "\n" not in str(error.value)


def test_a_facade_without_openings_names_the_stage(copy: Path) -> None:
    for stage in ("openings", "crossbars"):
        (copy / ".done" / f"{stage}.B01.json").unlink()
    with pytest.raises(WorkspaceError, match="frontage openings"):
        open_run(copy).locate("B01/F1/W1-1")


def test_a_project_that_this_version_does_not_read_is_told(copy: Path) -> None:
    path = copy / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["project"]["of_another_version"] = {}
    path.write_text(json.dumps(manifest))
    with pytest.raises(WorkspaceError, match="names no project of this version; run `frontage run` again"):
        open_run(copy).locate("13 rue Soufflot", floor=1, window=2)


def test_photos_that_have_gone_are_a_note(copy: Path, answers: list[Located]) -> None:
    path = copy / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["project"]["photos"]["path"] = str(copy / "nowhere" / "*.jpg")
    path.write_text(json.dumps(manifest))
    found = open_run(copy).locate(answers[0].id)
    assert found.outline == answers[0].outline and found.photos == ()
    assert any("photos could not be read" in note for note in found.notes)


def test_an_opening_on_an_oriel_lies_on_its_front_and_an_inferred_one_is_told(copy: Path) -> None:
    store = Store(copy)
    facade = store.facade("B01/F1")
    ring = rectangle(-1.0, 0.0, 1.0, 2.0)
    covariance = np.full((8, 8), 1e-4)  # all corners move together
    plain = Opening(
        "B01/F1/W1-1",
        "window",
        ring,
        covariance,
        None,
        "rectangle",
        Provenance.INFERRED,
        0.0,
        0.7,
        1,
        1,
        on="P",
    )
    front = Estimate(-0.6, np.array([[1e-4]]), 10.0)
    oriel = Protrusion("P", "oriel", rectangle(-2.0, -1.0, 2.0, 3.0), 0.01, front, Provenance.MEASURED, 1.0)
    save(store, "B01/F1", Elements("B01/F1", (plain,), (oriel,)))
    found = open_run(copy).locate("B01/F1/W1-1")
    expected = facade.world.to_world(facade.frame.apply(np.array([[-1.0, -0.6, 0.0]])))[0]
    assert np.allclose(found.corners[0], expected, atol=1e-4)
    assert found.depth is None and found.corners_inside is None and found.sigma["depth"] is None
    assert found.sigma["left"] == pytest.approx(0.01) and found.sigma["width"] == pytest.approx(0.0, abs=1e-9)
    assert any("not seen" in note for note in found.notes)


def test_doors_are_asked_for_by_the_number_of_their_id(copy: Path) -> None:
    store = Store(copy)
    covariance = np.eye(8) * 1e-4
    row = []
    for k, (letter, kind) in enumerate((("W", "window"), ("D", "door")), 1):
        ring = rectangle(2.0 * k, 0.0, 2.0 * k + 1, 2.0)
        seen = Provenance.MEASURED
        name = f"B01/F1/{letter}0-{k}"
        row.append(Opening(name, kind, ring, covariance, None, "rectangle", seen, 1.0, 1.0, 0, k))
    save(store, "B01/F1", Elements("B01/F1", tuple(row)))
    asked = open_run(copy)
    assert asked.locate("B01", floor=0, door=2).id == "B01/F1/D0-2"
    assert asked.locate("B01", floor=0, window=2).kind == "door"
    with pytest.raises(InputError, match="no door 1 on floor 0; there, from the left: W0-1, D0-2"):
        asked.locate("B01", floor=0, door=1)


def test_sight_is_blocked_by_what_stands_between(simulated_run: Path) -> None:
    store = Store(simulated_run)
    photos = store.photos()
    assert photos is not None
    photo = photos.photos[0]
    facade = store.facade("B01/F1")
    x, z = facade.outline.mean(0)
    ring = rectangle(x - 0.6, z - 0.8, x + 0.6, z + 0.8)
    middle = facade.frame.apply(np.array([[x, 0.0, z]]))[0]
    to_eye = photo.pose.t - middle
    u, w = (v.ravel() for v in np.meshgrid(*2 * [np.arange(-1.2, 1.2, 0.06)]))
    board = facade.frame.rotate(np.column_stack([u, np.zeros(len(u)), w]))

    def visible(cloud: Float | None) -> float | None:
        (seen,) = photo_views(
            facade, [(ring, 0.0)], [photo], None if cloud is None else scanned_surfaces(cloud)
        )
        return seen[0].visible if seen else None

    free = visible(None)  # a corner may lie outside the frame
    assert free is not None and free > 0.95
    assert visible(middle + 0.4 * to_eye + board) is None
    assert visible(middle + 1.4 * to_eye + board) == free  # behind the photographer
    assert visible(middle - 0.1 * to_eye + board) == free  # in the room
    part = visible(middle + 0.05 * to_eye + board[u > 0.2])
    assert part is not None and 0.5 <= part < 0.85
    assert photo_views(facade, [(ring, 0.0)], [replace(photo, local_from_camera=None)], None) == [()]


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def test_the_command_answers_people_and_machines(copy: Path, answers: list[Located]) -> None:
    told(copy, {"B01": "13 rue Soufflot"})
    wanted = next(a for a in answers if a.floor == 1 and a.number == 2)
    words = ("locate", copy, "13 rue Soufflot", "--floor", 1, "--window", 2)
    result = call(*words)
    assert result.exit_code == 0, result.output
    assert result.output.startswith(
        f"{wanted.id}: {wanted.kind} of 13 rue Soufflot, floor 1, number 2 from the left"
    )
    x, y, z = wanted.corners[0]
    assert f"lower left  {x:.3f} {y:.3f} {z:.3f}" in result.output
    answer = json.loads(call(*words, "--json").output)
    assert answer["id"] == wanted.id and answer["sigma"].keys() == wanted.sigma.keys()
    assert np.allclose(answer["outline"], wanted.outline)
    assert call("locate", copy, "B01/F1/" + wanted.id.rsplit("/", 1)[1].lower()).exit_code == 0
    wrong = call("locate", copy, "13 rue Soufflot", "--floor", 1, "--window", 77)
    assert wrong.exit_code == 1 and re.search(r"no opening 77 on floor 1", wrong.output)
    assert call("locate", copy, "13 rue Soufflot", "--floor", "third").exit_code == 2
