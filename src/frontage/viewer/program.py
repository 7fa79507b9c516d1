"""The built program of the viewer, which the wheel contains and `make viewer` builds in a checkout."""

from pathlib import Path

from frontage.errors import WorkspaceError

_FOLDER = Path(__file__).parent / "program"
_ENTRY = "index.html"


def program_files() -> dict[str, Path]:
    """Return the files of the program by their path in the site. Raises WorkspaceError if it is not built."""
    found = {path.relative_to(_FOLDER).as_posix(): path for path in _FOLDER.rglob("*") if path.is_file()}
    if _ENTRY not in found:
        raise WorkspaceError("the viewer is not built in this checkout; build it with `make viewer`")
    return found
