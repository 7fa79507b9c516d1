"""The nouns of Frontage, in which all rooms exchange their results.

They are frozen dataclasses over read-only numpy arrays, which are checked when an object is made and hold no
file paths. Frames, units and signs are explained on one page, docs/conventions.md; the facade frame and the
position of pixels are those of paper A, sections 2.2 and 3.2. There is no entry function.
"""

from frontage.model.building import Building, Footprint, Surface
from frontage.model.citymodel import CityBuilding, CityModel, Shell
from frontage.model.estimate import Estimate, Failed, Provenance
from frontage.model.facade import Facade, Layer
from frontage.model.glazing import AXES, FRAME_THICKNESS_M, Bar, Glazing
from frontage.model.noreturns import NoReturns
from frontage.model.occluder import OCCLUDER_KINDS, Occluder
from frontage.model.opening import (
    DOORS,
    OPENING_SURFACES,
    Elements,
    Opening,
    OpeningKind,
    Protrusion,
    ProtrusionKind,
)
from frontage.model.ortho import INFERRED, NOT_SEEN, OrthoImage, PhotoOffset, PhotoRemark
from frontage.model.photo import Camera, Photo
from frontage.model.rig import Exposure, MountedCamera, Rig
from frontage.model.scan import Grid, Scan, merge_scans
from frontage.model.shape import Feature, Polygons, Shape
from frontage.model.solid import Face, Finding, Solid
from frontage.model.world import WorldRef

__all__ = [
    "AXES",
    "DOORS",
    "FRAME_THICKNESS_M",
    "INFERRED",
    "NOT_SEEN",
    "OCCLUDER_KINDS",
    "OPENING_SURFACES",
    "Bar",
    "Building",
    "Camera",
    "CityBuilding",
    "CityModel",
    "Elements",
    "Estimate",
    "Exposure",
    "Facade",
    "Face",
    "Failed",
    "Feature",
    "Finding",
    "Footprint",
    "Glazing",
    "Grid",
    "Layer",
    "MountedCamera",
    "NoReturns",
    "Occluder",
    "Opening",
    "OpeningKind",
    "OrthoImage",
    "Photo",
    "PhotoOffset",
    "PhotoRemark",
    "Polygons",
    "Protrusion",
    "ProtrusionKind",
    "Provenance",
    "Rig",
    "Scan",
    "Shape",
    "Shell",
    "Solid",
    "Surface",
    "WorldRef",
    "merge_scans",
]
