"""Every example runs and prints truth beside estimate, within bounds."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("plot_*.py"))


def run(path: Path, folder: Path) -> str:
    """Run an example away from the repository, as someone with an installed package does."""
    command = [sys.executable, str(path)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_there_are_examples() -> None:
    assert {p.stem for p in EXAMPLES} == set(CHECKS)


def plane_is_right(out: str) -> bool:
    ours = re.search(r"lo-msac\s+(-?[\d.]+) mm\s+([\d.]+) mm\s+([\d.]+) deg", out)
    assert ours is not None
    offset, sigma, angle = (float(v) for v in ours.groups())
    return abs(offset) < 1.0 and 0 < sigma < 1.0 and angle < 0.005


def ortho_is_right(out: str) -> bool:
    found = re.search(r"(\d+) tiles of plain wall: median displacement ([\d.]+) px", out)
    assert found is not None
    return int(found[1]) >= 30 and 0 < float(found[2]) < 0.5


def steps_are_right(out: str) -> bool:
    plane = re.search(r"plane: ([+-][\d.]+) mm .* ([\d.]+) mm", out)
    openings = re.search(r"openings: (\d+); true: (\d+)", out)
    area = re.search(r"area: ([\d.]+) m2; true: ([\d.]+) m2", out)
    assert plane is not None and openings is not None and area is not None
    ratio = float(area[1]) / float(area[2])
    close = abs(float(plane[1])) < 5 and 0.95 < ratio < 1.05
    return close and openings[1] == openings[2] and "0 openings refused, 0 findings" in out


def run_is_right(out: str) -> bool:
    found = re.search(r"(\d+) openings: median size error ([\d.]+) mm", out)
    assert found is not None
    return int(found[1]) >= 5 and 0 < float(found[2]) < 10


CHECKS = {
    "plot_facade_plane": plane_is_right,
    "plot_ortho_image": ortho_is_right,
    "plot_step_by_step": steps_are_right,
    "plot_street_run": run_is_right,
}


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_runs_and_is_right(path: Path, tmp_path: Path) -> None:
    assert CHECKS[path.stem](run(path, tmp_path))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_needs_only_the_installed_package(path: Path) -> None:
    text = path.read_text("utf-8")
    assert "sys.path" not in text
    imported = set(re.findall(r"^(?:from|import) (\w+)", text, re.M))
    assert imported <= {"cv2", "frontage", "json", "numpy", "pathlib", "sys", "tempfile"}
