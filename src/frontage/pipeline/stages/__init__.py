"""The stages of the chain, one file each.

A stage is a `frontage.pipeline.graph.Stage`: what it reads, what it calls, what it writes, and what it
depends on. `STAGES` is the order of work; a new stage is a new file and a line here.
"""

from frontage.pipeline.stages import (
    bim,
    buildings,
    crossbars,
    drawings,
    elevations,
    export,
    facades,
    keypoints,
    matches,
    model,
    openings,
    orient,
    ortho,
    qgis,
    register,
    report,
    scans,
    tables,
)

STAGES = (
    scans.STAGE,
    register.STAGE,
    keypoints.STAGE,
    matches.STAGE,
    orient.STAGE,
    buildings.STAGE,
    facades.STAGE,
    ortho.STAGE,
    openings.STAGE,
    crossbars.STAGE,
    drawings.STAGE,
    model.STAGE,
    export.STAGE,
    tables.STAGE,
    elevations.STAGE,
    bim.STAGE,
    qgis.STAGE,
    report.STAGE,
)
