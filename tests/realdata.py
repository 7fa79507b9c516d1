"""The folder of the real data beside the checkout; tests that need it are skipped where it is missing."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"


def data_path(relative: str) -> Path:
    """Returns the path of a file or folder of the real data, or skips the test and says what is missing."""
    path = DATA / relative
    if not path.exists():
        pytest.skip(f"real data is absent: {relative}")
    return path
