"""Where the real data lies: a folder beside the checkout. Tests that need it are skipped without."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"


def data_path(relative: str) -> Path:
    """The path of a file or folder of the real data, or a skip that says what is missing."""
    path = DATA / relative
    if not path.exists():
        pytest.skip(f"real data is absent: {relative}")
    return path
