"""Photos without a scan: the adjustment of a block as a free network.

Nothing fixes where a block lies, which way it is turned, and how large it is. Inner constraints take these
seven freedoms out (`adjustment.datum`), so that the standard errors tell how well the photos know one
another. They are in units of the block.
"""

from dataclasses import replace

import numpy as np

from frontage.orientation.adjustment import Adjustment, AdjustmentOptions, Dependence, Network, Photos, adjust
from frontage.orientation.dependence import metres_per_pixel
from frontage.orientation.network import TIES, TiePoints, distinct_cameras, tie_images
from frontage.orientation.nouns import Block
from frontage.orientation.significance import CRITICAL

# Of a thousand good observations one fails (Baarda 1968).
_TESTS = AdjustmentOptions(critical=CRITICAL)
_ALIKE_PX = 140.0  # over which errors of tie points may be alike at least, as with a scan


def adjusted_block(block: Block) -> Block:
    """Returns a block adjusted as a free network: photos with covariances (6, 6), and points.

    Covariances are in block units and radians; they allow for errors of tie points that are alike at
    neighbouring places of a photo. Cameras are taken for exact. Measurements of points that nothing
    determines are left out. Raises NotDetermined when the tie points do not fix the photos.
    """
    result = free_network(block)
    photos = tuple(
        replace(photo, local_from_camera=result.photo_pose(k)) for k, photo in enumerate(block.photos)
    )
    number = np.cumsum(result.determined) - 1
    kept = result.determined[block.point] & result.used
    return replace(
        block,
        photos=photos,
        points=result.points[result.determined],
        photo=block.photo[kept],
        point=number[block.point[kept]],
        pixels=block.pixels[kept],
        sizes=None if block.sizes is None else block.sizes[kept],
    )


def free_network(block: Block) -> Adjustment:
    """Adjusts the tie points of a block under inner constraints on the poses."""
    cameras, number = distinct_cameras([photo.camera for photo in block.photos])
    ties = TiePoints(block.points, block.photo, block.point, block.pixels, block.sizes)
    poses = tuple(photo.pose for photo in block.photos)
    network = Network(
        poses, tuple(cameras), Photos.free(number), block.points, tie_images(block.photos, ties)
    )
    return adjust(network, _TESTS, dependence_of_ties(block))


def dependence_of_ties(block: Block) -> Dependence:
    """Returns which errors of tie points may be alike: those at neighbouring places of a photo."""
    pixel = [
        metres_per_pixel(photo, block.points[block.point[block.photo == k]])
        for k, photo in enumerate(block.photos)
    ]
    reach = _ALIKE_PX * float(np.median(np.concatenate(pixel)))
    return Dependence({TIES: reach}, own=frozenset({TIES}), shared=frozenset())
