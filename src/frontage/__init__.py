"""Measured facades: metric facade ortho-images and LoD3 building models from laser scans and photographs.

The names in `__all__` are the public interface and follow semantic versioning; everything else is private and
may change. They are imported when they are first used::

    import frontage

    summary = frontage.run("street.toml", "out")
    run = frontage.open_run("out")
    run.facade("B01/F1").pixel_to_world(300.5, 120.5)
    run.locate("13 rue Soufflot", floor=3, window=2)

or step by step on nouns: `read_scans`, `find_buildings`, `find_facades`, `make_ortho`, `find_openings`,
`find_bars`, `build_model`, `validate`.
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from frontage.api import (
        build_model,
        find_bars,
        find_buildings,
        find_facades,
        find_openings,
        locate,
        make_ortho,
        open_run,
        read_photos,
        read_scans,
        run,
        validate,
    )

__all__ = [
    "__version__",
    "build_model",
    "find_bars",
    "find_buildings",
    "find_facades",
    "find_openings",
    "locate",
    "make_ortho",
    "open_run",
    "read_photos",
    "read_scans",
    "run",
    "validate",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module 'frontage' has no attribute {name!r}")
    value = getattr(importlib.import_module("frontage.api"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return list(__all__)
