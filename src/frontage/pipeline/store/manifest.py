"""The manifest: what a run was made from, with which versions, and what every stage told."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from frontage.pipeline.store.results import StageResult, StageWarning, result_from_json, result_to_json


@dataclass(frozen=True)
class InputFile:
    """A file that the run read: path, size in bytes, SHA-256 as hex digits."""

    path: str
    size: int
    sha256: str


Inputs = Mapping[str, tuple[InputFile, ...]]
"""The files that a project reads, by group: "scans", "photos", "model"."""


@dataclass(frozen=True)
class StageRecord:
    """A finished stage: its key, how long it took, and its result as JSON."""

    key: str
    seconds: float
    result: Mapping[str, Any]

    @property
    def items(self) -> int:
        """How many things the stage made."""
        return int(self.result["items"])

    @property
    def warnings(self) -> tuple[StageWarning, ...]:
        """What went wrong with single items."""
        return tuple(StageWarning(**warning) for warning in self.result["warnings"])

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know."""
        return tuple(self.result["notes"])

    @classmethod
    def of(cls, key: str, seconds: float, result: StageResult) -> "StageRecord":
        """Return the record of a stage that has just ended."""
        return cls(key, round(seconds, 3), result_to_json(result))


@dataclass(frozen=True)
class Manifest:
    """The contents of manifest.json; `stages` are in the order of the chain."""

    frontage: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0
    project: Mapping[str, Any] | None = None
    inputs: Inputs = field(default_factory=dict)
    stages: Mapping[str, StageRecord] = field(default_factory=dict)

    @property
    def world(self) -> Mapping[str, Any] | None:
        """CRS and origin of the local frame; None before any scan was read."""
        scans = self.stages.get("scans")
        return None if scans is None else dict(scans.result["world"])

    @property
    def warnings(self) -> list[tuple[str, StageWarning]]:
        """All warnings, each with the name of its stage."""
        return [(name, warning) for name, stage in self.stages.items() for warning in stage.warnings]

    @property
    def notes(self) -> list[str]:
        """All notes, in the order of the stages."""
        return [note for stage in self.stages.values() for note in stage.notes]

    def to_json(self) -> dict[str, Any]:
        """Return the manifest as it stands in the file."""
        return {
            "frontage": self.frontage,
            "versions": dict(self.versions),
            "seed": self.seed,
            "project": self.project,
            "inputs": {group: [asdict(file) for file in files] for group, files in self.inputs.items()},
            "world": self.world,
            "stages": {
                name: {"key": stage.key, "seconds": stage.seconds, **stage.result}
                for name, stage in self.stages.items()
            },
            "warnings": [{"stage": stage, **asdict(warning)} for stage, warning in self.warnings],
            "notes": self.notes,
        }

    @classmethod
    def from_json(cls, table: Any) -> "Manifest":
        """Return the inverse of `to_json`. Raises ValueError, TypeError or KeyError for anything else."""
        if not isinstance(table, dict) or not isinstance(table.get("stages", {}), dict):
            raise ValueError("it holds no JSON object")
        stages = {
            name: StageRecord(str(entry["key"]), float(entry["seconds"]), _result(entry))
            for name, entry in table.get("stages", {}).items()
        }
        inputs = {
            group: tuple(result_from_json(InputFile, file) for file in files)
            for group, files in table.get("inputs", {}).items()
        }
        return cls(
            table.get("frontage", ""),
            table.get("versions", {}),
            int(table.get("seed", 0)),
            table.get("project"),
            inputs,
            stages,
        )


def _result(entry: Mapping[str, Any]) -> dict[str, Any]:
    result = {name: value for name, value in entry.items() if name not in ("key", "seconds")}
    if not {"items", "warnings", "notes"} <= result.keys():
        raise ValueError("a stage lacks its items, warnings or notes")
    result_from_json(StageResult, {name: result[name] for name in ("items", "warnings", "notes")})
    return result
