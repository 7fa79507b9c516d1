"""Cuts reliefs into a host and leaves out those with which the solid would not be valid."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from frontage.model import Failed, Solid
from frontage.solids.cells.build import build_solid
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs
from frontage.validation import validate

_MAX_NAMED = 3  # findings named in a warning


def sound_solid(building: str, host: Solid, facades: Sequence[FacadeReliefs], options: BuildOptions) -> Built:
    """Returns the solid with as many reliefs as leave it valid; those left out are told as S320."""
    cut = _Cut(host, facades, options)
    every = [relief.id for facade in facades for relief in facade.reliefs]
    built = cut.with_reliefs(every)
    findings = validate(built.solid)
    if not findings:
        return built
    kept = cut.valid_part([], every)
    sound = cut.with_reliefs(kept)
    named = "; ".join(f"{f.code} {f.message}" for f in findings[:_MAX_NAMED])
    left = ", ".join(name for name in every if name not in kept)
    text = f"{building}: the solid is not valid with {left} ({len(findings)} findings: {named})"
    return replace(sound, failed=(*sound.failed, Failed("S320", text, "please report this case")))


@dataclass(frozen=True, eq=False)
class _Cut:
    """A host and what is to be cut into it."""

    host: Solid
    facades: Sequence[FacadeReliefs]
    options: BuildOptions

    def with_reliefs(self, names: Sequence[str]) -> Built:
        """Returns the host with the named reliefs cut in, or the host alone if it is not closed."""
        chosen = set(names)
        own = [replace(f, reliefs=tuple(r for r in f.reliefs if r.id in chosen)) for f in self.facades]
        made = build_solid(self.host, own, self.options)
        return made if isinstance(made, Built) else Built(self.host, self.host, failed=(made,))

    def valid_part(self, kept: list[str], more: list[str]) -> list[str]:
        """The reliefs that are kept, and as many more, half by half, as leave the solid valid."""
        both = kept + more
        if not validate(self.with_reliefs(both).solid):
            return both
        if len(more) == 1:
            return kept
        half = len(more) // 2
        return self.valid_part(self.valid_part(kept, more[:half]), more[half:])
