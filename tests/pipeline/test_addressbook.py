"""The addresses of a project file: two forms, and one sentence for every mistake."""

from pathlib import Path
from typing import Any

import pytest

from frontage.errors import OptionError
from frontage.pipeline.project import Project, load_project

SCAN = '[[scans]]\npath = "a.laz"\n'


def project(folder: Path, text: str) -> Project:
    file = folder / "PROJECT.toml"
    file.write_text(SCAN + text, "utf-8")
    return load_project(file)


def entries(given: Project) -> list[tuple[str, str | None, tuple[float, float] | None]]:
    return [(e.address, e.building, e.at) for e in given.addresses]


def test_by_id_one_or_several(tmp_path: Path) -> None:
    found = project(tmp_path, '[addresses]\nB07 = "13 rue Soufflot"\nB08 = ["15 rue Soufflot", "2 rue X"]\n')
    assert entries(found) == [
        ("13 rue Soufflot", "B07", None), ("15 rue Soufflot", "B08", None), ("2 rue X", "B08", None),
    ]  # fmt: skip


def test_by_a_place(tmp_path: Path) -> None:
    text = '[[addresses]]\naddress = "a"\nat = [651602.5, 6860834]\n'
    text += '[[addresses]]\naddress = "b"\nbuilding = "B1"\n'
    assert entries(project(tmp_path, text)) == [("a", None, (651602.5, 6860834.0)), ("b", "B1", None)]


def test_none_is_the_default_and_all_survive_the_manifest(tmp_path: Path) -> None:
    assert project(tmp_path, "").addresses == ()
    given = project(tmp_path, '[addresses]\nB07 = "13 rue Soufflot"\n')
    assert Project.model_validate(given.model_dump(mode="json")).addresses == given.addresses


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[addresses]\nB07 = 13\n", 'write B07 = "13 rue Soufflot"'),
        ('[addresses]\nB07 = ""\n', "at least 1 character"),
        ('[addresses]\nB07 = "a"\nB08 = "A"\n', '"A" is given to two places'),
        ('[[addresses]]\naddress = "a"\n', "needs either building"),
        ('[[addresses]]\naddress = "a"\nat = [1, 2]\nbuilding = "B1"\n', "needs either building"),
        ('[[addresses]]\naddress = "a"\nat = [1, nan]\n', "two finite numbers"),
        ('[[addresses]]\naddress = "a"\nat = [1]\n', "'addresses.0.at.1' is missing"),
        ('[[addresses]]\naddress = "a"\nat = [1, 2]\nfloor = 1\n', "unknown key 'addresses.0.floor'"),
        ('addresses = "a"\n', None),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_a_sentence(tmp_path: Path, text: str, sentence: Any) -> None:
    file = tmp_path / "PROJECT.toml"
    file.write_text(text + SCAN if sentence is None else SCAN + text, "utf-8")
    with pytest.raises(OptionError, match=sentence or "addresses = 'a' is not usable") as told:
        load_project(file)
    assert "\n" not in str(told.value)
