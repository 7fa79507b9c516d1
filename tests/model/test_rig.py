"""A rig refuses what cannot be: a camera in two places, or a photo taken twice."""

import pytest

from frontage.model import Exposure, MountedCamera, Rig

CAMERAS = (MountedCamera("left"), MountedCamera("right"))


def test_a_rig_keeps_which_camera_took_what():
    rig = Rig("car", CAMERAS, (Exposure("0", ("l0", "r0"), (0, 1)), Exposure("1", ("r1",), (1,))))
    assert rig.exposures[1].photos == ("r1",) and rig.cameras[1].body_from_camera is None


@pytest.mark.parametrize(
    ("exposures", "message"),
    [
        ((Exposure("0", ("a",), (2,)),), "names no camera"),
        ((Exposure("0", ("a", "b"), (0,)),), "names no camera"),
        ((Exposure("0", ("a", "b"), (1, 1)),), "camera right took two photos of 0"),
        ((Exposure("0", ("a",), (0,)), Exposure("1", ("b", "a"), (0, 1))), "photo a was taken twice"),
        ((Exposure("0", ("a", "a"), (0, 1)),), "photo a was taken twice"),
    ],
)
def test_what_cannot_be_is_refused(exposures, message):
    with pytest.raises(ValueError, match=message):
        Rig("car", CAMERAS, exposures)
