"""`frontage orient` and `frontage run --photo-pose` as a user meets them."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from frontage.cli.main import main
from frontage.pipeline.project import Project
from orientation.orientedscene import pair_run, scene_of


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scene_of(tmp_path_factory)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder with two photos that were oriented."""
    pytest.importorskip("pycolmap")
    return pair_run(tmp_path_factory)


def centres(out: Path) -> dict[str, list[float]]:
    table = json.loads((out / "orientation" / "report.json").read_text())
    return {entry["photo"]: entry["center"] for entry in table["photos"]}


def test_orienting_again_gives_the_same(out: Path, tmp_path: Path) -> None:
    before = centres(out)
    assert before.keys() == {"IMG_0002.jpg", "IMG_0003.jpg"}
    again = tmp_path / "again"
    shutil.copytree(out, again)
    (again / "orientation" / "report.json").unlink()
    result = call("orient", again, "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["items"]["orient"] == 2
    after = centres(again)
    assert after.keys() == before.keys()
    assert all(np.array_equal(after[name], before[name]) for name in before)


def test_trusted_photos_have_nothing_to_orient(simulated_run: Path, tmp_path: Path) -> None:
    result = call("orient", shutil.copytree(simulated_run, tmp_path / "copy"))
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1 and "Traceback" not in result.stderr
    assert "nothing to do for 'orient': all photos have trusted poses" in result.stderr


def test_a_folder_that_is_no_run_is_one_sentence(tmp_path: Path) -> None:
    result = call("orient", tmp_path)
    assert result.exit_code == 1 and len(result.stderr.splitlines()) == 1
    assert call("orient").exit_code == 2


class Asked(Exception):
    """Carries the project that a run was asked for."""


def test_the_flag_says_how_far_poses_are_trusted(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Project] = []

    def remember(project: Project, *_: object, **__: object) -> None:
        asked.append(project)
        raise Asked

    monkeypatch.setattr("frontage.pipeline.run.run", remember)
    words = (
        "run",
        "--scan",
        scene / "scans" / "S1.e57",
        "--photos",
        scene / "photos",
        "-o",
        tmp_path / "out",
    )
    for pose in ("approximate", "none"):
        call(*words, "--photo-pose", pose)
        assert asked[-1].photos is not None and asked[-1].photos.pose == pose
    call(*words)
    assert asked[-1].photos is not None and asked[-1].photos.pose == "trusted"
    assert asked[-1].scans[0].pose == "trusted"
    count = len(asked)
    assert call(*words, "--photo-pose", "perhaps").exit_code == 2
    assert call("run", scene / "project.toml", "--photo-pose", "none").exit_code == 2
    assert len(asked) == count


def test_photos_without_cameras_need_a_pose_that_is_not_trusted(scene: Path, tmp_path: Path) -> None:
    words = (
        "run",
        "--scan",
        scene / "scans" / "S1.e57",
        "--photos",
        scene / "photos",
        "-o",
        tmp_path / "out",
    )
    result = call(*words, "--quiet")
    assert result.exit_code == 1 and "I111" in result.stderr
    assert len(result.stderr.splitlines()) == 1
