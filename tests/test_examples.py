"""Every example runs and prints truth beside estimate, within bounds."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("plot_*.py"))


def run(path: Path, *args: str) -> str:
    done = subprocess.run([sys.executable, str(path), *args], capture_output=True, text=True, check=False)
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
    found = re.search(r"(\d+) window edges: median error ([\d.]+) mm", out)
    assert found is not None
    return int(found[1]) >= 10 and 0 < float(found[2]) < 8  # photos of 1.5 cm a pixel


CHECKS = {"plot_facade_plane": plane_is_right, "plot_ortho_image": ortho_is_right}


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_runs_and_is_right(path: Path) -> None:
    assert CHECKS[path.stem](run(path))
