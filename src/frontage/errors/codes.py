"""What every numbered code means and what to do about it.

The first letter names the origin: I input, F facades and their stages, O orientation of photos, R
registration, S solids, W run folder and workers, X optional dependencies, E anything else. The findings of
the validator are not listed here: they carry val3dity's own numbers (see `frontage.validation`).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class ErrorCode(NamedTuple):
    """A numbered code: what it means, and what the user can do about it."""

    meaning: str
    remedy: str


CODES: Mapping[str, ErrorCode] = MappingProxyType(
    {
        # Anything else
        "E000": ErrorCode(
            "Frontage stopped with an error that has no number of its own.", "Read the message."
        ),
        "E999": ErrorCode(
            "An item failed with an unexpected error, which is a bug in Frontage.",
            "Run again with -v to see the traceback, and report it. The other items are not affected.",
        ),
        # Orientation of photos
        "O100": ErrorCode("The observations do not determine some poses.", "Take photos that overlap more."),
        "O101": ErrorCode(
            "A photo could not be matched with the others, nor be found in the scan on its own.",
            "Give its approximate pose, or take photos between it and the others.",
        ),
        "O102": ErrorCode(
            "Photos that were matched with one another could not be found in the scan.",
            "Check that the scan shows what they show, and that approximate poses are right.",
        ),
        "O103": ErrorCode(
            "Photos fit at two places of the scan about as well, as on a facade of equal windows.",
            "Give better approximate poses, or a photo that shows a corner or an entrance.",
        ),
        "O104": ErrorCode(
            "The scan, drawn at the pose that was found for a photo, is found elsewhere in the photo; or "
            "the pose contradicts the approximate one, and too few control points support it.",
            "Give a better approximate pose, or leave the photo out.",
        ),
        "O105": ErrorCode(
            "Too few tie points and control points support a pose.", "Take photos that overlap more."
        ),
        "O106": ErrorCode(
            "The scan lacks what photos are to be compared with.", "Choose another [orientation] source."
        ),
        # Facades, ortho-images, openings
        "F100": ErrorCode(
            "The run found no facade at all.",
            "Check that the scan shows walls of buildings, and read the warnings of the earlier stages.",
        ),
        "F101": ErrorCode(
            "The building has too few points for a facade.",
            "Scan the building more densely, or leave it out.",
        ),
        "F102": ErrorCode(
            "The building has no upright plane of the minimum area.",
            "Lower [facades] min_area if the building is small; check that z points up in the scan.",
        ),
        "F301": ErrorCode(
            "No scan point lies on the facade and there are no photos, so there is nothing to draw.",
            "Check the facade's outline and the scan.",
        ),
        "F302": ErrorCode(
            "No photo and no scan point shows the facade.",
            "Check the poses of the photos.",
        ),
        "F303": ErrorCode(
            "The photos see the facade at another depth than the scan, beyond the uncertainty of both. "
            "The picture is drawn at the depth that the photos show.",
            "Either the scan or the photos are shifted: check the scan's georeference and the poses.",
        ),
        "F304": ErrorCode(
            "Photos were given, but none shows this facade. Its picture is drawn from the scan.",
            "If photos were taken of the facade, check their poses and [photos] offset.",
        ),
        "F305": ErrorCode(
            "A photo agrees with the scan and the other photos no more often than by chance, where those "
            "agree with each other: its pose is wrong, or it is another picture. It is left out.",
            "Check the pose of the photo, and whether the file is the one that the cameras were made for.",
        ),
        "F306": ErrorCode(
            "The EXIF orientation of photos turns them by half a turn or mirrors them, and nothing tells "
            "whether their cameras take it into account. They are left out.",
            "Store the photos as their cameras mean them, and remove the EXIF orientation.",
        ),
        "F307": ErrorCode(
            "Photos were turned as their EXIF orientation states, because only so they agree with the scan "
            "or the other photos.",
            "Nothing needs to be done.",
        ),
        "F401": ErrorCode(
            "The facade has too few points to tell openings from gaps in the scan.",
            "Scan from closer or more densely: an opening needs about ten points across.",
        ),
        "F402": ErrorCode(
            "The facade shows hardly any wall, so openings cannot be told from it.",
            "Check the facade's plane, or scan it from the street.",
        ),
        # Input: files
        "I000": ErrorCode("Something that the user gave cannot be used.", "Correct what the message names."),
        "I100": ErrorCode("A file cannot be used.", "Follow the advice in the message."),
        "I101": ErrorCode(
            "A file or folder does not exist, cannot be opened, or is not of a known kind.",
            "Check the path, the permissions and the ending of the name.",
        ),
        "I102": ErrorCode("The file is empty.", "Export or copy it again."),
        "I103": ErrorCode(
            "The file is truncated, damaged, or not of the format that its name says.",
            "Copy or export it again; repair a city model in which no building can be used.",
        ),
        "I104": ErrorCode(
            "A file cannot be written.", "Check the folder, its permissions and the free space."
        ),
        "I105": ErrorCode(
            "The file is well-formed but holds nothing that can be used: no points, cameras or buildings.",
            "Check that it is the right file, and that the bounds meet its contents.",
        ),
        "I106": ErrorCode(
            "A column that is needed is missing: the coordinates x, y, z, or the GPS time of the points.",
            "Rename the columns or export the file with them.",
        ),
        "I107": ErrorCode("The scan spans more than 400 km and does not fit a LAS file.", "Split the scan."),
        "I108": ErrorCode(
            "The list of stations is empty, names a station twice, or names one without a position.",
            "Correct the *.stations.json file.",
        ),
        "I109": ErrorCode(
            "The trajectory cannot be used: columns are missing, it is too short, or its times do not meet "
            "those of the points.",
            "Check its header row (gps_time, x, y, z) and that it belongs to this scan.",
        ),
        "I110": ErrorCode(
            "An image of the COLMAP model refers to a camera that the model does not have.",
            "Export the model again.",
        ),
        "I111": ErrorCode(
            "Photos are given as oriented, but nothing states their cameras and poses.",
            'Add cameras = "..." under [photos], or pose = "approximate" or "none" to orient them.',
        ),
        "I112": ErrorCode(
            "The cameras and the photos do not match: a photo is missing or is found twice.",
            "Check [photos] path.",
        ),
        "I113": ErrorCode(
            "A photo does not have the size of its camera.",
            "Use the photos that the cameras were made for, in their original size.",
        ),
        "I114": ErrorCode(
            "The file has a format, or a version of a format, that Frontage does not read.",
            "Convert it to one of the formats that the message names.",
        ),
        "I115": ErrorCode(
            "The contents of a file do not fit into memory.",
            "Split the file, thin it, or use a computer with more memory; check its units.",
        ),
        "I116": ErrorCode(
            "The coordinates of a scan are stored so coarsely that facades cannot be measured.",
            "Export the scan with 64-bit floats, or with a shift that you state as offset.",
        ),
        "I120": ErrorCode(
            "Some polygons of a building in the city model are unusable; the rest of the building is used.",
            "Repair this building in the model if its solid looks wrong.",
        ),
        "I121": ErrorCode(
            "A building of the city model has no usable polygon and is left out.",
            "Repair this building in the model.",
        ),
        # Input: coordinate reference systems
        "I200": ErrorCode(
            "A coordinate reference system cannot be used.", "Follow the advice in the message."
        ),
        "I201": ErrorCode(
            "The coordinate reference system is unknown.",
            "Use a code such as EPSG:25832 or EPSG:25832+7837.",
        ),
        "I202": ErrorCode(
            "Some of the data has a coordinate reference system and some has none.",
            'State the missing one with crs = "EPSG:...".',
        ),
        "I203": ErrorCode(
            "The target is not a projected CRS with axes east and north, or no UTM zone fits the data.",
            "Name a projected CRS in metres, such as EPSG:25832.",
        ),
        "I204": ErrorCode(
            "Coordinates lie outside the area of their CRS.", "Check the crs that was given for the file."
        ),
        "I205": ErrorCode(
            "No transformation of known accuracy is installed for this pair of reference systems.",
            "Install the grids for PROJ, or choose another target CRS.",
        ),
        "I206": ErrorCode(
            "No building of the city model is near the scans.", "Check its CRS and that it covers the place."
        ),
        # Input: options
        "I300": ErrorCode(
            "An option or an entry of the project file is unknown or out of range.",
            "Correct the entry; `frontage run --help` and the reference list all of them.",
        ),
        "I310": ErrorCode(
            "The camera model is unknown, has the wrong number of parameters, or has no calibration matrix.",
            "Use one of COLMAP's models; use the full projection with panoramas.",
        ),
        "I311": ErrorCode(
            "The point pairs do not determine a homography.",
            "Give at least four pairs, no three of them on a line.",
        ),
        "I320": ErrorCode(
            "The ortho-image would have more pixels than can be handled.", "Choose a larger [ortho] gsd."
        ),
        "I321": ErrorCode("The window does not lie within the raster.", "Check its rows and columns."),
        "I322": ErrorCode(
            "The work would need more memory, or more space for temporary files, than there is.",
            "Check that the coordinates are in metres; choose a larger [ortho] gsd.",
        ),
        # Registration
        "R201": ErrorCode(
            "The scan fits the city model at more than one place about equally well.",
            "Give better positions (a smaller sigma_position) or scan more of the street.",
        ),
        # Solids
        "S301": ErrorCode("The host solid is not closed.", "Repair it."),
        "S302": ErrorCode(
            "The city model has too few usable polygons of the building for a solid.",
            "Use another level of detail, or let a block be made from the facades.",
        ),
        "S303": ErrorCode(
            "The building's polygons in the city model do not close.",
            "Repair the model, or let a block be made from the ground or the facades.",
        ),
        "S304": ErrorCode(
            "No block can be made from this outline or ground polygon.",
            "Check the outline, the depth and the ground polygon, or give a city model.",
        ),
        "S305": ErrorCode(
            "The building has no facade, or none near a wall of the city model, to build from.",
            "Check the registration, or raise max_offset.",
        ),
        "S306": ErrorCode("The coarse solid of the building is not valid.", "Repair or give a city model."),
        "S310": ErrorCode(
            "No wall of the host solid lies where the facade, the opening or the protrusion was measured.",
            "Check the registration, or raise max_offset.",
        ),
        "S311": ErrorCode(
            "Less than half of the outline lies on free wall, so the element is left out.",
            "Check the outlines of the elements that the message names, or the host's wall there.",
        ),
        "S312": ErrorCode(
            "The outline crosses itself or has no area, so the element is left out.",
            "Repair the outline.",
        ),
        "S313": ErrorCode(
            "The outline overlaps or surrounds another one, so the element is left out.",
            "Correct one of the outlines; give an inner opening as lying inside the outer one.",
        ),
        "S314": ErrorCode(
            "The element is narrower than the smallest gap that the solid may have.", "Leave it out."
        ),
        "S315": ErrorCode("The element would meet another part of the building.", "Check its depth."),
        "S316": ErrorCode(
            "The element touches another one in a single point and cannot be separated from it.",
            "Separate or join the two.",
        ),
        "S318": ErrorCode(
            "The protrusion does not make a valid solid, so it is left out.",
            "Check its outline in protrusions.json.",
        ),
        "S320": ErrorCode(
            "With this element the solid of the building would not be valid, so it is left out.",
            "Report this case.",
        ),
        "S399": ErrorCode(
            "Cutting the opening would leave the solid open, so the wall stays as it was.",
            "Report this case; no example of it is known.",
        ),
        # Run folder and workers
        "W100": ErrorCode("The run folder cannot be used.", "Follow the advice in the message."),
        "W110": ErrorCode(
            "Another run works on this run folder.",
            "Wait until it ends or stop it. If it ended on another host, remove the lock file.",
        ),
        "W300": ErrorCode(
            "A worker process was killed, most often because memory ran out. Finished results are kept.",
            "Run again with fewer --workers.",
        ),
        # Optional dependencies
        "X100": ErrorCode(
            "An optional dependency is needed but not installed.",
            "Install the extra that the message names.",
        ),
    }
)
