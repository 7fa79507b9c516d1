"""The stage `buildings`: split the street into buildings (paper A, section 2.1), a working cloud for each."""

from dataclasses import dataclass, replace

from frontage.buildings import BuildingSplit, find_buildings
from frontage.io.citymodels.footprints import read_footprints
from frontage.model import Footprint, Scan
from frontage.pipeline.clouds import Neighbourhoods, around, thin_to, working_cloud
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.stages.scans import approximate
from frontage.pipeline.store.records import BuildingRecord
from frontage.pipeline.store.results import StageResult

_MAP_ERROR_M = 20.0  # maps are not further off than this; buildings beyond are left unread
_SURROUNDINGS_VOXEL_M = 0.05


@dataclass(frozen=True)
class PointCounts:
    """How many points belong to no building: ground, things before the buildings, and the rest."""

    ground: int
    occluders: int
    rest: int


@dataclass(frozen=True, kw_only=True)
class BuildingsResult(StageResult):
    """What splitting found; `spacing` is the median distance of neighbouring points, m."""

    spacing: float
    points: PointCounts


@dataclass(frozen=True, eq=False)
class Street:
    """The cloud of all scans in place, and the footprints of the map near it."""

    scan: Scan
    footprints: tuple[Footprint, ...]


@dataclass(frozen=True, eq=False)
class Split:
    """The street and how it was split."""

    scan: Scan
    found: BuildingSplit


def load(job: Job) -> Street:
    """Read the cloud and the map."""
    scan, model = job.store.cloud(registered=approximate(job.project)), job.project.model
    if model is None:
        return Street(scan, ())
    near = around([scan], _MAP_ERROR_M)
    return Street(scan, tuple(read_footprints(model.path, scan.world, model.crs, near)))


def work(job: Job, street: Street) -> Split:
    """Split the street."""
    return Split(street.scan, find_buildings(street.scan, job.project.buildings, street.footprints))


def save(job: Job, split: Split) -> BuildingSplit:
    """Write the thinned street; per building its LAZ, its working cloud, and which points are its own."""
    scan, found = split.scan, split.found
    thinned = scan.take(thin_to(scan.xyz, max(_SURROUNDINGS_VOXEL_M, found.spacing)))
    job.store.save_surroundings(replace(thinned, no_returns=()))
    neighbourhoods = Neighbourhoods(scan.xyz)
    records = []
    for building in job.each(found.buildings):
        cloud, own = working_cloud(scan, neighbourhoods, building.index)
        job.store.save_building(building.id, cloud, own)
        records.append(BuildingRecord.of(building, len(own)))
    job.store.save_building_records(records, scan.world)
    return found


def join(job: Job, parts: list[BuildingSplit]) -> BuildingsResult:
    """Tell how many buildings there are."""
    (found,) = parts
    return BuildingsResult(
        items=len(found.buildings),
        spacing=found.spacing,
        points=PointCounts(len(found.ground), len(found.occluders), len(found.rest)),
        notes=tuple(found.notes),
    )


STAGE = Stage(
    name="buildings",
    after=("scans", After("register")),
    load=load,
    work=work,
    save=save,
    join=join,
    result=BuildingsResult,
    rooms=("buildings",),
    inputs=("model",),
    options=("model.crs", "buildings"),
)
