"""The stage `scans`: read every scan into one local frame and merge them."""

from dataclasses import dataclass

from frontage.errors import InputError
from frontage.geometry.arrays import Float
from frontage.io.photos.read import read_photos
from frontage.io.scans.read import read_scans
from frontage.model import Scan, merge_scans
from frontage.pipeline.project import Project
from frontage.pipeline.stage import Job, Stage
from frontage.pipeline.store.results import ScansResult, WorldRecord


@dataclass(frozen=True, eq=False)
class Clouds:
    """All scans in the world of the first: each with the number of its source, and merged."""

    parts: tuple[tuple[int, Scan], ...]
    merged: Scan


def approximate(project: Project) -> bool:
    """Tell whether any scan of the project has to be registered."""
    return any(source.pose == "approximate" for source in project.scans)


def load(job: Job) -> list[tuple[int, Scan]]:
    """Read the scans, and the photos' poses too, so that bad ones are told before the long work."""
    project, found = job.project, list[tuple[int, Scan]]()
    for number, source in enumerate(job.each(project.scans)):
        world = found[0][1].world if found else None
        found += [(number, scan) for scan in read_scans(source, world, project.project.crs)]
    if project.photos is not None and found:
        read_photos(project.photos, found[0][1].world)
    return found


def work(job: Job, parts: list[tuple[int, Scan]]) -> Clouds:
    """Merge the scans."""
    merged = merge_scans([scan for _, scan in parts])
    if not len(merged):
        names = ", ".join(str(source.path) for source in job.project.scans)
        raise InputError(f"{names}: no points; give a scan that has some")
    return Clouds(tuple(parts), merged)


def save(job: Job, clouds: Clouds) -> Clouds:
    """Write the merged cloud, and every scan as given if it has to be registered."""
    job.store.save_cloud(clouds.merged)
    if approximate(job.project):
        for k, (_, scan) in enumerate(clouds.parts):
            job.store.save_part(k, scan)
    return clouds


def join(job: Job, parts: list[Clouds]) -> ScansResult:
    """Tell what the scans hold."""
    (clouds,) = parts
    merged, world = clouds.merged, clouds.merged.world
    x, y, z = (int(v) for v in world.origin)
    low, high = world.to_world(merged.xyz.min(0)), world.to_world(merged.xyz.max(0))
    return ScansResult(
        items=len(merged),
        world=WorldRecord(world.crs, (x, y, z)),
        extent=(_point(low), _point(high)),
        rays=merged.has_origins,
        looks=merged.intensity is not None or merged.rgb is not None,
        parts=tuple(number for number, _ in clouds.parts) if approximate(job.project) else (),
        notes=tuple(merged.notes),
    )


def _point(xyz: Float) -> tuple[float, float, float]:
    x, y, z = xyz.tolist()
    return x, y, z


STAGE = Stage(
    name="scans",
    load=load,
    work=work,
    save=save,
    join=join,
    result=ScansResult,
    inputs=("scans",),
    options=("project.crs", "scans"),
)
