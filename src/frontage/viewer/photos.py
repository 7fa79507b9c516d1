"""Photos at the size of a screen."""

import cv2

from frontage.model import Photo
from frontage.viewer.run import Run

_LONGEST_PX = 1600
_JPEG_QUALITY = 85


def photo_jpeg(run: Run, photo: Photo) -> bytes:
    """Return a photo as JPEG, its longer side at most 1600 px. Raises FileError if it cannot be read."""
    assert run.witnesses.photos is not None  # it is one of them
    image = run.witnesses.photos.image(photo.id)
    scale = min(1.0, _LONGEST_PX / max(image.shape[:2]))
    if scale < 1:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    made: bytes = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[
        1
    ].tobytes()
    return made
