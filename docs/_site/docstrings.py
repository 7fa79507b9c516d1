"""Turns the argument lists of our docstrings into Markdown lists.

In the source an argument or field is described on a line of its own, `name  what it is`, with two spaces or
more between and further lines indented. Markdown would run such lines together.
"""

import re
from typing import Any

from griffe import Extension, Object

ENTRY = re.compile(r"^(\w[\w.]*(?:, \w[\w.]*)*) {2,}(\S.*)$")
LONE = re.compile(r"^(\w+(?:, \w+)*) (\S.*)$")


def as_markdown(text: str) -> str:
    """The docstring with every paragraph of `name  description` lines as a list."""
    return "\n\n".join(_paragraph(block) for block in re.split(r"\n\s*\n", text))


def _paragraph(block: str) -> str:
    lines = block.splitlines()
    if not lines or not ENTRY.match(lines[0]):
        return block
    items: list[str] = []
    for line in lines:
        entry = ENTRY.match(line)
        if entry:
            names = ", ".join(f"`{name}`" for name in entry[1].split(", "))
            items.append(f"- {names}: {entry[2]}")
        elif line.startswith(" ") or not LONE.match(line):
            items[-1] += f" {line.strip()}"
        else:  # an entry whose name is as long as the column
            name, _, rest = line.partition(" ")
            items.append(f"- `{name}`: {rest.strip()}")
    return "\n".join(items)


class ArgumentLists(Extension):
    """Applies `as_markdown` to every docstring."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Rewrite the docstring of a loaded object."""
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)
