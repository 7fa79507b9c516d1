"""A run folder against the truth of the scene it was made from: every part that the folder holds."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from frontage.errors import FileError, FrontageError, InputError, OptionError
from frontage.evaluation.buildings import score_buildings
from frontage.evaluation.facades import score_facades
from frontage.evaluation.metric import Absent, Metric, ScorePart
from frontage.evaluation.openings import score_openings
from frontage.evaluation.ortho import score_orthos
from frontage.evaluation.poses import score_poses
from frontage.evaluation.protrusions import score_protrusions
from frontage.evaluation.truth import Truth, read_truth
from frontage.pipeline.store.files import read_json
from frontage.studies.runresults import Results

PARTS = ("buildings", "facades", "ortho", "openings", "protrusions", "model", "photos", "scans")
_GATE = re.compile(r"\s*([a-z]+)\.([a-z0-9_]+)\s*(<=|>=)\s*([-+0-9.eE]+)\s*$")


@dataclass(frozen=True)
class Scores:
    """What a run scored: every part with its figures, or why it is absent."""

    run: Path
    scene: str
    parts: Mapping[str, ScorePart | Absent]

    def table(self) -> dict[str, Any]:
        """JSON-able."""
        out: dict[str, Any] = {"run": str(self.run), "scene": self.scene, "parts": {}, "absent": {}}
        for name, part in self.parts.items():
            if isinstance(part, Absent):
                out["absent"][name] = part.reason
            else:
                figures = {key: asdict(figure) for key, figure in part.figures.items()}
                out["parts"][name] = {"figures": figures, "items": part.items, "notes": part.notes}
        return out


@dataclass(frozen=True)
class Gate:
    """A bound that a figure must keep: `part.figure <= value` or `>=`."""

    part: str
    figure: str
    at_most: bool
    value: float

    def __str__(self) -> str:
        return f"{self.part}.{self.figure} {'<=' if self.at_most else '>='} {self.value:g}"

    def holds(self, scores: Scores) -> tuple[bool, str]:
        """Whether the run keeps the bound, and a sentence; what is absent keeps none.

        Raises OptionError when a part that is there has no figure of that name.
        """
        part = scores.parts[self.part]
        if isinstance(part, Absent):
            return False, f"{self}: {self.part} is absent ({part.reason})"
        if self.figure not in part.figures:
            raise OptionError(f"{self.part} has no figure {self.figure!r}; it has {', '.join(part.figures)}")
        figure: Metric = part.figures[self.figure]
        if figure.value is None:
            return False, f"{self}: there was nothing to compute it from"
        kept = figure.value <= self.value if self.at_most else figure.value >= self.value
        return kept, f"{self}: {figure.value:.6g}"


def parse_gate(text: str) -> Gate:
    """`openings.f1_50>=0.9` as a Gate. Raises OptionError with what would be right."""
    match = _GATE.match(text)
    if match is None or match[1] not in PARTS:
        raise OptionError(
            f"cannot read the bound {text!r}; write part.figure<=value or part.figure>=value, "
            f"with a part of {', '.join(PARTS)}"
        )
    try:
        value = float(match[4])
    except ValueError:
        raise OptionError(f"{match[4]!r} in the bound {text!r} is not a number") from None
    return Gate(match[1], match[2], match[3] == "<=", value)


def truth_folder(path: Path | str) -> Path:
    """The folder with truth.json: given itself, its file, or the folder of the simulated scene.

    Raises FileError when there is none.
    """
    given = Path(path)
    for place in (given, given / "truth", given.parent):
        if (place / "truth.json").is_file() and (place is not given.parent or given.name == "truth.json"):
            return place
    raise FileError(given, "holds no truth.json", "give the folder that `frontage simulate` wrote")


def load_truth(path: Path | str) -> tuple[Truth, Path]:
    """The truth and the folder that its files are relative to. Raises FileError, InputError."""
    folder = truth_folder(path)
    try:
        table = read_json(folder / "truth.json")
    except ValueError as error:
        raise FileError(folder / "truth.json", f"is not JSON ({error})", "simulate the scene again") from None
    if not isinstance(table, dict):
        raise InputError(f"{folder / 'truth.json'}: not the truth of a simulated scene")
    return read_truth(table, str(folder / "truth.json")), folder.parent


def score(run: Path | str, truth_path: Path | str, sensors: Sequence[str] = ()) -> Scores:
    """Score every part of a run folder.

    sensors  those that tell what could be seen ("stations", "drive", "photos"); default: those the run read,
             for buildings and planes those that measured its points

    Raises WorkspaceError when `run` is no run folder, FileError and InputError for the truth, InputError
    when both lie in different coordinate systems.
    """
    truth, base = load_truth(truth_path)
    results = Results(Path(run), truth, base)
    seen = tuple(sensors) or results.sensors()
    measured = tuple(sensors) or tuple(s for s in seen if s != "photos") or seen
    makers: dict[str, Callable[[], ScorePart | Absent]] = {
        "buildings": lambda: _scored(
            results.points(), lambda p: score_buildings(truth, p, len(p.names), measured)
        ),
        "facades": lambda: _scored(results.facades(), lambda f: score_facades(truth, f, measured)),
        "ortho": lambda: _scored(results.orthos(), score_orthos),
        "openings": lambda: _scored(results.openings(), lambda o: score_openings(truth, o, seen)),
        "protrusions": lambda: _scored(results.protrusions(), lambda p: score_protrusions(truth, p)),
        "model": lambda: _scored(results.model(), lambda o: score_openings(truth, o, seen)),
        "photos": lambda: _scored(results.photos(), lambda p: score_poses(truth.photos, p)),
        "scans": lambda: _scored(results.scans(), lambda p: score_poses(truth.scans, p)),
    }
    return Scores(Path(run), truth.name, {name: _kept(name, makers[name]) for name in PARTS})


def _scored(found: Any, scorer: Callable[[Any], ScorePart]) -> ScorePart | Absent:
    """The scores of what was found; Absent is handed on."""
    return found if isinstance(found, Absent) else scorer(found)


def _kept(name: str, maker: Callable[[], ScorePart | Absent]) -> ScorePart | Absent:
    """A part whose files are damaged says so with its name; the sentence is the file's own."""
    try:
        return maker()
    except FrontageError as error:
        raise InputError(f"{name} cannot be scored: {error}") from None
