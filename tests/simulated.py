"""The spec of a tiny scene that is simulated in a few seconds, and what tests read of it."""

import json
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
    """The contents of a scene's truth.json."""
    table: dict[str, Any] = json.loads((scene / "truth" / "truth.json").read_text())
    return table
