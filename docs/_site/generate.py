"""The parts of the reference that are generated from the code, as Markdown.

`SECTIONS` maps the name in a page's `{{ generated: NAME }}` to the function that writes it.
Nothing here needs mkdocs, so that the tests can call it.
"""

import enum
import importlib
import re
import textwrap
import types
import typing
from pathlib import Path
from typing import Any

import click
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

ROOT = Path(__file__).resolve().parents[2]
# The first letter of an error code says what it is about.
FAMILIES = {
    "I": "Input: files, coordinate systems, options",
    "O": "Orientation of photos",
    "R": "Registration",
    "F": "Facades, ortho-images and openings",
    "S": "Solids and models",
    "W": "The run folder",
    "X": "Optional dependencies",
    "E": "Everything else",
}


def command_line() -> str:
    """Every command with its usage, help text and options, from the click commands themselves."""
    from frontage.cli.main import COMMANDS, main

    parts = []
    for name in COMMANDS:
        command = main.get_command(click.Context(main), name)
        assert command is not None
        context = click.Context(command, info_name=f"frontage {name}")
        usage = command.get_usage(context).removeprefix("Usage: ")
        text = "\n\n".join(_paragraphs(command.help or COMMANDS[name]))
        parts.append(f"## frontage {name}\n\n```\n{' '.join(usage.split())}\n```\n\n{text}\n")
        rows = [_option(parameter) for parameter in command.params if isinstance(parameter, click.Option)]
        if rows:
            parts.append(_table(("option", "default", "meaning"), rows))
    return "\n".join(parts)


def _paragraphs(text: str) -> list[str]:
    blocks = re.split(r"\n\s*\n", text.replace("\b\n", "\f").strip())
    return [f"```\n{b.strip(chr(12)).strip()}\n```" if "\f" in b else " ".join(b.split()) for b in blocks]


def _option(option: click.Option) -> tuple[str, str, str]:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    if not option.is_flag and not option.count:
        choices = getattr(option.type, "choices", None)
        names += f" `{'|'.join(choices)}`" if choices else f" {option.metavar or option.type.name.upper()}"
    default = option.default
    plain = isinstance(default, str | int | float) and not isinstance(default, bool) and not option.count
    return names, f"`{default}`" if plain else "", option.help or ""


def project_file() -> str:
    """Every table of the project file with its keys, from the pydantic models that check them."""
    from frontage.pipeline.project import Project

    parts = []
    for name, field in Project.model_fields.items():
        model, listed = _model_of(field.annotation)
        if model is None:
            continue
        title = f"[[{name}]]" if listed else f"[{name}]"
        parts.append(f"## `{title}`\n\n{_first_paragraph(model)}\n\n{fields_table(model)}")
    return "\n".join(parts)


def fields_table(model: type[BaseModel]) -> str:
    """The keys of one table: type, default, allowed values and meaning."""
    rows = [
        (f"`{key}`", _type_name(field), _default(field), _meaning(field))
        for key, field in model.model_fields.items()
    ]
    return _table(("key", "type", "default", "meaning"), rows)


def _model_of(annotation: Any) -> tuple[type[BaseModel] | None, bool]:
    """The pydantic model inside an annotation, and whether the file has a list of them."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation, False
    for inner in typing.get_args(annotation):
        model, _ = _model_of(inner)
        if model is not None:
            return model, typing.get_origin(annotation) is tuple
    return None, False


def _first_paragraph(model: type[BaseModel]) -> str:
    return " ".join((model.__doc__ or "").strip().split("\n\n")[0].split())


def _type_name(field: FieldInfo) -> str:
    return _spell(field.annotation)


def _spell(annotation: Any) -> str:
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Literal:
        return ", ".join(f"`{value!r}`".replace("'", '"') for value in inner)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(_spell(one) for one in inner if one is not type(None))
    if origin is tuple:
        return f"list of {_spell(inner[0])}" if inner[-1] is Ellipsis else f"{len(inner)} numbers"
    if isinstance(annotation, type) and issubclass(annotation, enum.Enum):
        return ", ".join(f'`"{one.value}"`' for one in annotation)
    names = {float: "number", int: "integer", str: "text", bool: "true or false", Path: "path"}
    return names.get(annotation, getattr(annotation, "__name__", str(annotation)))


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.default
    if value is PydanticUndefined or value is None or value == ():
        return ""
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _meaning(field: FieldInfo) -> str:
    symbols = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    bounds = [
        f"{symbol} {getattr(one, name)}"
        for one in field.metadata
        for name, symbol in symbols.items()
        if getattr(one, name, None) is not None
    ]
    return (field.description or "") + (f" ({', '.join(bounds)})" if bounds else "")


def error_codes() -> str:
    """Every numbered code: what it means and what to do about it."""
    table: dict[str, Any] = importlib.import_module("frontage.errors").CODES
    parts = []
    for letter, title in FAMILIES.items():
        codes = sorted(code for code in table if code.startswith(letter))
        if codes:
            rows = [(f'<span id="{c.lower()}">{c}</span>', table[c].meaning, table[c].remedy) for c in codes]
            parts.append(f"## {letter}: {title}\n\n" + _table(("code", "what it means", "what to do"), rows))
    assert set(FAMILIES) >= {code[0] for code in table}, "a family of codes has no title"
    return "\n".join(parts)


def changelog() -> str:
    """CHANGELOG.md without its title, with links that work on the site."""
    return _relinked((ROOT / "CHANGELOG.md").read_text("utf-8").split("\n", 1)[1])


def contributing() -> str:
    """CONTRIBUTING.md without its title, with links that work on the site."""
    return _relinked((ROOT / "CONTRIBUTING.md").read_text("utf-8").split("\n", 1)[1])


def tour() -> str:
    """The tour of the README, which a test runs."""
    readme = (ROOT / "README.md").read_text("utf-8")
    body = readme.split("\n## Five minutes\n", 1)[1].split("\n## ", 1)[0]
    return _relinked(body)


def _relinked(text: str) -> str:
    return text.replace("](docs/", "](").replace("](CHANGELOG.md)", "](changelog.md)")


def examples() -> str:
    """The scripts of the gallery: what each shows, what it prints, and its text."""
    parts = []
    for path in sorted((ROOT / "examples").glob("plot_*.py")):
        text = path.read_text("utf-8")
        _, docstring, code = text.split('"""', 2)
        title, _, rest = docstring.strip().partition("\n")
        parts.append(f"## {title.rstrip('.')}\n\n{rest.strip()}\n\n`examples/{path.name}`\n")
        output = Path(__file__).with_name("outputs") / f"{path.stem}.txt"
        parts.append(f"```text\n{output.read_text('utf-8').rstrip()}\n```\n")
        if (ROOT / "docs" / "images" / f"{path.stem}.jpg").exists():
            parts.append(f"![The picture that the script writes](../images/{path.stem}.jpg)\n")
        parts.append(
            f'??? example "The script"\n\n    ```python\n{textwrap.indent(code.strip(), "    ")}\n    ```\n'
        )
    return "\n".join(parts)


def public_api() -> str:
    """One mkdocstrings entry for every name that `import frontage` promises."""
    import frontage

    names = [name for name in getattr(frontage, "__all__", ()) if not name.startswith("_")]
    return "\n\n".join(f"::: {_home(name)}" for name in names)


def _home(name: str) -> str:
    """The full dotted name of the module that defines a public name: static analysis needs that."""
    import frontage

    thing = getattr(frontage, name)
    module = getattr(thing, "__module__", None) or "frontage"
    return f"{module}.{getattr(thing, '__qualname__', name)}"


def _table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += [
        "| " + " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in row) + " |" for row in rows
    ]
    return "\n".join(lines) + "\n"


SECTIONS = {
    "changelog": changelog,
    "command_line": command_line,
    "contributing": contributing,
    "error_codes": error_codes,
    "examples": examples,
    "project_file": project_file,
    "public_api": public_api,
    "tour": tour,
}
