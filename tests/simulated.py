"""Specs of scenes that are simulated in a few seconds, and a reader of their truth."""

import json
import re
from pathlib import Path
from typing import Any

TINY = """
name = "tiny"
seed = 5
houses = 1
opposite = false
trees = 1
cars = 1
people = 0
lamps = 0
slope = 2.0
[[scanners]]
stations = 2
spacing = 0.05
field = 150
lowest = -25
highest = 45
subrays = 1
[[cameras]]
width = 720
height = 720
most = 2
distance = 10.0
[output]
gsd = 0.02
"""

# Two unlike houses, the second one set back, for tests that run the whole chain many times.
PAIR = """
name = "pair"
seed = 2
opposite = false
setting = "terrace"
slope = 0
street_width = 14
trees = 1
cars = 1
people = 0
lamps = 0
[[house]]
lean = 0
floors = 3
[[house]]
lean = 0
floors = 2
setback = 0.3
[[scanners]]
stations = 2
spacing = 0.08
field = 170
lowest = -25
highest = 60
subrays = 1
[[cameras]]
width = 450
height = 600
most = 2
samples = 1
[output]
scans = "laz"
gsd = 0.04
"""

# The smallest scene that still has every kind of file.
BARE = """
seed = 2
houses = 1
opposite = false
trees = 0
cars = 0
people = 0
lamps = 0
[[scanners]]
stations = 2
spacing = 0.25
field = 90
lowest = -10
highest = 30
subrays = 1
[drive]
profile_rate = 10
beams = 120
overrun = 2
subrays = 1
[[cameras]]
width = 120
height = 90
most = 1
samples = 1
[[cameras]]
model = "SIMPLE_RADIAL"
width = 90
height = 120
most = 1
samples = 1
[output]
gsd = 0.1
"""


def truth_of(scene: Path) -> dict[str, Any]:
    """Returns the contents of a scene's truth.json."""
    table: dict[str, Any] = json.loads((scene / "truth" / "truth.json").read_text())
    return table


def without_model(project: Path) -> Path:
    """Takes the city model out of a scene's project file, so that houses are told apart by their scans."""
    text, count = re.subn(r"\[model\]\npath = .*\n\n", "", project.read_text())
    assert count == 1, text
    project.write_text(text)
    return project
