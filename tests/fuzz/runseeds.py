"""The files of a run folder that commands read again, as seeds of mutations."""

from pathlib import Path

from fuzz.seeds import Make, Seed

RUN_FILES = {
    "manifest.json": "json",
    ".done/scans.json": "json",
    ".done/openings.B01.json": "json",
    "buildings/index.json": "json",
    "buildings/B01.npz": "npz",
    "buildings/B01.index.npy": "numbers",
    "facades/B01_F1/facade.json": "json",
    "facades/B01_F1/points.npz": "npz",
    "facades/B01_F1/openings.json": "json",
    "facades/B01_F1/protrusions.json": "json",
    "facades/B01_F1/outlines.npz": "npz",
    "facades/B01_F1/ortho.json": "json",
    "facades/B01_F1/ortho.tif": "numbers",
    "facades/B01_F1/depth.tif": "numbers",
}
"""Files of a run folder that commands read again, and what they are made of."""


def run_seeds(out: Path) -> tuple[Seed, ...]:
    """The files of a finished run folder as seeds; each is mutated in a folder of links to the others."""

    def maker(name: str) -> Make:
        def make(folder: Path) -> Path:
            for path in out.rglob("*"):
                if path.is_file():
                    target = folder / path.relative_to(out)
                    target.parent.mkdir(parents=True, exist_ok=True)
                    if path == out / name:
                        target.write_bytes(path.read_bytes())
                    else:
                        target.symlink_to(path)
            return folder / name

        return make

    return tuple(
        Seed(name, "run", (kind,), maker(name)) for name, kind in RUN_FILES.items() if (out / name).is_file()
    )


def small_run(folder: Path) -> Path:
    """The run folder of the smallest simulated scene."""
    from frontage.pipeline.project import load_project
    from frontage.pipeline.run import run
    from frontage.simulate.spec import parse_spec
    from frontage.studies.simulate import simulate
    from simulated import BARE

    scene = simulate(parse_spec(BARE), folder / "scene")
    run(load_project(scene.project), folder / "run")
    return folder / "run"


_BY_SUFFIX = {
    ".las": ("scan", "las"), ".laz": ("scan", "las"), ".e57": ("scan", "e57"), ".ptx": ("scan", "text"),
    ".ply": ("scan", "head"), ".xyz": ("scan", "text"), ".jpg": ("photo", "jpeg"), ".png": ("photo", "png"),
    ".tif": ("photo", "numbers"), ".json": ("validate", "json"), ".jsonl": ("validate", "json"),
    ".gml": ("validate", "xml"), ".obj": ("validate", "text"), ".off": ("validate", "text"),
    ".poly": ("validate", "text"), ".geojson": ("city", "json"), ".gpkg": ("city", "numbers"),
}  # fmt: skip
_LARGEST_FILE = 1_000_000  # bytes, so that a case takes a moment


def folder_seeds(top: Path) -> tuple[Seed, ...]:
    """The small files of a folder, such as real recordings, as seeds; they are copied, never changed."""

    def maker(path: Path) -> Make:
        def make(folder: Path) -> Path:
            (folder / path.name).write_bytes(path.read_bytes())
            return folder / path.name

        return make

    found = (p for p in sorted(top.rglob("*")) if p.suffix.lower() in _BY_SUFFIX and p.is_file())
    return tuple(
        Seed(path.relative_to(top).as_posix(), reader, (kind,), maker(path))
        for path in found
        if 0 < path.stat().st_size <= _LARGEST_FILE
        for reader, kind in [_BY_SUFFIX[path.suffix.lower()]]
    )
