"""What stages tell: frozen dataclasses, and the one way in which they become JSON and come back."""

from dataclasses import dataclass, field
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from frontage.io.facadefile import world_from_json
from frontage.model import Failed, WorldRef

T = TypeVar("T")


@dataclass(frozen=True)
class StageWarning:
    """What went wrong with one item: the numbered code, one sentence, and advice."""

    item: str
    code: str
    message: str
    hint: str = ""

    @classmethod
    def of(cls, item: str, failed: Failed) -> "StageWarning":
        """Return the warning that `item` failed."""
        return cls(item, failed.code, failed.message, failed.hint)


@dataclass(frozen=True, kw_only=True)
class ItemResult:
    """What a stage made of one building: the facades that it has a result for, and what went wrong."""

    facades: tuple[str, ...] = ()
    warnings: tuple[StageWarning, ...] = ()


@dataclass(frozen=True, kw_only=True)
class StageResult:
    """What a stage made of the whole run. The fields become entries of the stage in the manifest.

    items     how many things it made
    warnings  what went wrong with single items
    notes     sentences that the user should know
    """

    items: int
    warnings: tuple[StageWarning, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class WorldRecord:
    """The world reference: CRS name or None, and the integer origin of the local frame in m."""

    crs: str | None
    origin: tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class ScansResult(StageResult):
    """What the scans hold, and the frame that everything else is computed in.

    extent  lower and upper corner of all points, m, world
    rays    whether points know where they were measured from
    looks   whether points have intensity or colour
    parts   the number of the project's scan source of every scan that was kept as given
    """

    world: WorldRecord
    extent: tuple[tuple[float, float, float], tuple[float, float, float]]
    rays: bool
    looks: bool
    parts: tuple[int, ...]

    @property
    def world_ref(self) -> WorldRef:
        """The local frame of the run."""
        return world_from_json(result_to_json(self.world))


@dataclass(frozen=True)
class EvidencePicture:
    """A picture of what openings were found from: file stem, caption, edges x0, z0, x1, z1 m."""

    name: str
    caption: str
    extent: tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class NotedItemResult(ItemResult):
    """The same, with notes for the user per facade."""

    notes: dict[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class OpeningsItemResult(NotedItemResult):
    """What was found on the facades of one building: ids, and the pictures of every facade."""

    openings: tuple[str, ...] = ()
    protrusions: tuple[str, ...] = ()
    pictures: dict[str, tuple[EvidencePicture, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class WindowPicture:
    """A picture of what the bars of an opening were found from: file in the facade's folder, its panels."""

    opening: str
    file: str
    panels: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class CrossbarsItemResult(NotedItemResult):
    """What was found in the windows of one building.

    resolved    ids of the windows whose layout was decided
    bars        number of bars in them
    unresolved  reasons with the ids of the windows that were looked at in vain
    pictures    per facade
    """

    resolved: tuple[str, ...] = ()
    bars: int = 0
    unresolved: dict[str, tuple[str, ...]] = field(default_factory=dict)
    pictures: dict[str, tuple[WindowPicture, ...]] = field(default_factory=dict)


def result_to_json(result: Any) -> Any:
    """Return a result dataclass as JSON values."""
    return _adapter(type(result)).dump_python(result, mode="json")


def result_from_json(kind: type[T], table: Any) -> T:
    """Return the inverse of `result_to_json`. Raises ValueError if `table` is not a `kind`."""
    try:
        found: T = _adapter(kind).validate_python(table)
        return found
    except ValidationError as error:
        raise ValueError(f"it is no {kind.__name__}: {error.errors()[0]['msg']}") from None


_ADAPTERS: dict[Any, TypeAdapter[Any]] = {}


def _adapter(kind: Any) -> TypeAdapter[Any]:
    """Return the adapter of a type; building one takes milliseconds, so they are kept."""
    if kind not in _ADAPTERS:
        _ADAPTERS[kind] = TypeAdapter(kind)
    return _ADAPTERS[kind]
