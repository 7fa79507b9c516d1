"""The project file: what to read, how to compute. DESIGN section 6; the flags of `frontage run` mirror it.

Paths in a project file are relative to the file; globs are expanded here, sorted, so that the order of the
inputs never depends on the disk.
"""

import glob
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from frontage.buildings import BuildingOptions
from frontage.catalog.addressbook import AddressBook
from frontage.crossbars import CrossbarOptions
from frontage.errors import FileError, OptionError
from frontage.facades import FacadeOptions
from frontage.io.files import text_of
from frontage.io.photos.read import PhotoSource
from frontage.io.scans.read import ScanSource
from frontage.openings.options import OpeningOptions
from frontage.orientation import OrientationOptions
from frontage.ortho import OrthoOptions
from frontage.registration import RegistrationOptions
from frontage.solids import BuildOptions

_FORBID = ConfigDict(extra="forbid", frozen=True)
_NO_PROJECT = "give a PROJECT.toml, or scans with --scan"


class General(BaseModel):
    """The `[project]` table."""

    model_config = _FORBID

    name: str | None = Field(
        default=None, min_length=1, description="title of the run; default: that of its folder"
    )
    crs: str | None = Field(
        default=None, description="projected metric CRS of the result; default: the scans' own"
    )
    seed: int = Field(default=0, ge=0, description="seed of every random choice")


class ModelSource(BaseModel):
    """The `[model]` table: a city model or footprints, which tell where a house ends and the next begins."""

    model_config = _FORBID

    path: Path = Field(description="CityJSON, CityGML, GeoJSON or GeoPackage file")
    crs: str | None = Field(default=None, description="CRS of the file, over what it says itself")


class Project(BaseModel):
    """A whole project: inputs and options, every path absolute."""

    model_config = _FORBID

    project: General = General()
    scans: tuple[ScanSource, ...] = ()
    photos: PhotoSource | None = None
    model: ModelSource | None = None
    registration: RegistrationOptions = Field(default_factory=RegistrationOptions)
    buildings: BuildingOptions = Field(default_factory=BuildingOptions)
    facades: FacadeOptions = Field(default_factory=FacadeOptions)
    orientation: OrientationOptions = Field(default_factory=OrientationOptions)
    ortho: OrthoOptions = Field(default_factory=OrthoOptions)
    openings: OpeningOptions = Field(default_factory=OpeningOptions)
    crossbars: CrossbarOptions = Field(default_factory=CrossbarOptions)
    solids: BuildOptions = Field(default_factory=BuildOptions)
    addresses: AddressBook = ()

    @model_validator(mode="after")
    def _has_points(self) -> Self:
        if not self.scans:
            raise ValueError("no scan is given; name at least one with [[scans]] path = ... or --scan")
        return self


def load_project(path: Path, changes: Mapping[str, Mapping[str, Any]] | None = None) -> Project:
    """Read a project file (TOML), with the values in `changes` (table -> key -> value) in place of its own.

    Raises FileError when it is missing or not TOML, OptionError for an unknown key or a value out of range.
    """
    try:
        table = tomllib.loads(text_of(path, _NO_PROJECT).removeprefix("\ufeff"))
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not valid TOML: {error}", "correct that line") from None
    except RecursionError:
        raise FileError(path, "is nested too deeply to be a project", _NO_PROJECT) from None
    for name, values in (changes or {}).items():
        if values and isinstance(table.setdefault(name, {}), dict):
            table[name] |= values
    try:
        return make_project(table, path.resolve().parent, str(path))
    except RecursionError:
        raise FileError(path, "is nested too deeply to be a project", _NO_PROJECT) from None


def make_project(table: Mapping[str, Any], base: Path, name: str = "the project") -> Project:
    """A checked project from a table shaped like the file; paths are relative to `base`.

    A project without scans whose cameras folder has points uses those points as its cloud.
    Raises FileError for a path that matches nothing, OptionError for keys and values.
    """
    table = dict(table)
    try:
        table["scans"] = [one for scan in _tables(table, "scans", name) for one in _scan_tables(scan, base)]
        if "photos" in table:
            table["photos"] = _absolute(table["photos"], base, ("path", "cameras", "rig"), globs=True)
            table["photos"] = found_offset(table["photos"])
            if not table["scans"]:
                table["scans"] = _points_of_cameras(table["photos"])
        if "model" in table:
            table["model"] = _absolute(table["model"], base, ("path",))
        project = Project.model_validate(table)
    except ValidationError as error:
        raise OptionError(f"{name}: {sentence(error)}") from None
    _refuse_unregistered(project, name)
    return project


def project_from_table(table: Mapping[str, Any]) -> Project:
    """Return the checked project of a table with absolute paths. Raises OptionError."""
    try:
        return Project.model_validate(table)
    except ValidationError as error:
        raise OptionError(sentence(error)) from None


def _tables(table: Mapping[str, Any], key: str, name: str) -> list[dict[str, Any]]:
    value = table.get(key, [])
    if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
        raise OptionError(f"{name}: {key} must be a list of tables; write [[{key}]] with two brackets")
    return value


def _scan_tables(scan: dict[str, Any], base: Path) -> list[dict[str, Any]]:
    """One table per file that the scan's path matches."""
    if "path" not in scan:
        return [scan]  # the check names the missing key
    scan = _absolute(scan, base, ("trajectory", "stations"))
    return [{**scan, "path": path} for path in _matches(base, str(scan["path"]))]


def _matches(base: Path, pattern: str) -> list[str]:
    path = _placed(base, pattern)
    if not glob.has_magic(path) or Path(path).exists():
        return [path]
    found = sorted(glob.glob(path, recursive=True))
    if not found:
        raise FileError(pattern, "matches no file", f"paths are relative to {base}")
    return found


def _placed(base: Path, given: str) -> str:
    """Return a path of the project as an absolute one. Raises FileError for what can be no path."""
    try:
        path = (base / Path(given).expanduser()).absolute()
        path.lstat()
    except FileNotFoundError:
        return str(path)
    except PermissionError:
        return str(path)  # reading it tells more
    except (RuntimeError, ValueError, OSError) as error:  # no such user, a NUL, a name that is too long
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(given, f"cannot be a path ({reason.rstrip('.').lower()})", "correct it") from None
    return str(path)


def _absolute(table: Any, base: Path, keys: tuple[str, ...], globs: bool = False) -> Any:
    """The table with the paths under `keys` made absolute; lists of paths are kept lists."""
    if not isinstance(table, dict):
        return table  # the check names the wrong type
    out = dict(table)
    for key in keys:
        value = out.get(key)
        if isinstance(value, list):
            out[key] = [_placed(base, str(v)) for v in value]
        elif value is not None:
            out[key] = _placed(base, str(value))
    return out


def found_offset(photos: Any) -> Any:
    """Photos with the offset of an `offset.txt` (three numbers) in their cameras folder, if none is given."""
    if not isinstance(photos, dict) or "offset" in photos or not photos.get("cameras"):
        return photos
    file = Path(photos["cameras"]) / "offset.txt"
    if not file.is_file():
        return photos
    try:
        offset = [float(v) for v in file.read_text().replace(",", " ").split()]
    except ValueError:
        offset = []
    if len(offset) != 3:
        raise FileError(file, "does not hold three numbers", "write x y z in metres or give [photos] offset")
    return {**photos, "offset": offset}


def _points_of_cameras(photos: Any) -> list[dict[str, Any]]:
    """The COLMAP points as the cloud, when no scan is given."""
    cameras = Path(photos["cameras"]) if isinstance(photos, dict) and photos.get("cameras") else None
    if cameras and any((cameras / f"points3D.{end}").is_file() for end in ("txt", "bin")):
        return [{"path": str(cameras), **({"offset": photos["offset"]} if "offset" in photos else {})}]
    return []


def _refuse_unregistered(project: Project, name: str) -> None:
    """Poses of scans that nothing given can improve."""
    for scan in project.scans:
        if scan.pose != "trusted" and project.model is None:
            raise OptionError(
                f'{name}: {scan.path} has pose = "{scan.pose}" and there is no city model to register it to; '
                f'name one with [model] path = ... or --model, or give a registered scan and pose = "trusted"'
            )


def sentence(error: ValidationError) -> str:
    """The first thing that is wrong, in one sentence, with what would be right."""
    first = error.errors()[0]
    where = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        return f"unknown key {where!r}; known there: {', '.join(_known(first['loc']))}"
    if first["type"] == "value_error":
        return f"{where + ': ' if where else ''}{str(first['msg']).removeprefix('Value error, ')}"
    if first["type"] == "missing":
        return f"{where!r} is missing"
    return f"{where} = {first['input']!r} is not usable: {_lower(first['msg'])}"


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def _known(location: tuple[int | str, ...]) -> list[str]:
    """The keys allowed where an unknown one was found."""
    fields: Any = Project
    for part in location[:-1]:
        if isinstance(part, int):
            continue
        fields = _inner(fields.model_fields[part].annotation)
    return sorted(fields.model_fields)


def _inner(annotation: Any) -> Any:
    """The pydantic model inside `tuple[Model, ...]`, `Model | None` or `Model`."""
    for arg in getattr(annotation, "__args__", ()):
        if isinstance(arg, type) and issubclass(arg, BaseModel):
            return arg
    return annotation
