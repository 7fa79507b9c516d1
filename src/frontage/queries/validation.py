"""Validate files: read their geometries, check each feature, gather what was found."""

import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from frontage.errors import FileError, UnsupportedFormat
from frontage.io.shapes.read import Primitive, read_shapes
from frontage.model import Feature, Finding
from frontage.validation import Tolerances, validate_feature

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class FileFindings:
    """What validation found in one file: its format, features and geometries by kind, findings."""

    path: Path
    format: str
    features: dict[str, int]
    geometries: dict[str, int]
    findings: tuple[Finding, ...]

    @property
    def valid(self) -> bool:
        """Whether nothing was found."""
        return not self.findings

    @property
    def codes(self) -> dict[int, int]:
        """How often each code was found, in order."""
        return dict(sorted(Counter(f.code for f in self.findings).items()))


def validate_file(
    path: str | Path,
    tolerances: Tolerances | None = None,
    primitive: Primitive = "Solid",
    inner: Sequence[str | Path] = (),
) -> FileFindings:
    """Validate every geometry of a file; see `frontage.io.shapes.read.read_shapes` for the formats.

    A file that cannot be read has one finding, 901 (missing, empty, corrupt) or 904 (format not supported); a
    file without any geometry that could be checked has 902.

    Raises OptionError when `inner` does not fit the file.
    """
    p = Path(path)
    try:
        kind, features = read_shapes(p, primitive, inner)
    except FileError as error:
        code = 904 if isinstance(error, UnsupportedFormat) else 901
        return FileFindings(p, "", {}, {}, (Finding(code, str(error)),))
    findings = [f for feature in features for f in _checked(feature, tolerances or Tolerances())]
    everything = [f for feature in features for f in _with_parts(feature)]
    if not any(f.shapes for f in everything):
        findings.append(Finding(902, "the file holds no surface or solid that could be checked"))
    return FileFindings(
        p,
        kind,
        dict(sorted(Counter(f.kind for f in everything).items())),
        dict(sorted(Counter(s.kind for f in everything for s in f.shapes).items())),
        tuple(findings),
    )


def _with_parts(feature: Feature) -> list[Feature]:
    return [feature, *(f for part in feature.parts for f in _with_parts(part))]


def _checked(feature: Feature, tolerances: Tolerances) -> tuple[Finding, ...]:
    """The findings on a feature; a fault of the validator itself is one too (999) and ends no run."""
    try:
        return validate_feature(feature, tolerances)
    except Exception as problem:
        log.info("feature %s", feature.id, exc_info=True)
        text = f"the validator failed here ({type(problem).__name__}: {problem}); report it"
        return (Finding(999, " ".join(text.split()), "", feature.id),)
