"""Rasters in blocks and levels."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from frontage.errors import FileError
from frontage.io.rasters.geotiff import Georeference, write_geotiff
from frontage.viewer.bands import BLOCK_PX, Block, Blocks

SIZE = (2500, 1300)  # three blocks by two, then two by one, then one


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("raster")
    x, z = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    bands = [x // 10, z // 10, np.full_like(x, 90), np.where(x < 2000, 255, 0)]
    rgba = np.stack(bands, -1).astype(np.uint8)
    about = Georeference((0.0, 0.0), 0.01, "wall", {})
    write_geotiff(found / "ortho.tif", rgba, about)
    write_geotiff(found / "sources.tif", (x // 100).astype(np.uint16), about)
    return found


def picture(blocks: Blocks, block: Block) -> np.ndarray:
    found = cv2.imdecode(np.frombuffer(blocks.picture(block), np.uint8), cv2.IMREAD_COLOR)
    assert found is not None
    return found[..., ::-1].astype(int)


def test_levels_end_with_one_block_and_cover_the_picture(folder: Path) -> None:
    blocks = Blocks(folder, SIZE)
    assert blocks.levels == 3
    assert [b.name("photo") for b in blocks.all()] == [
        *(f"photo_0_{c}_{r}" for r in range(2) for c in range(3)),
        "photo_1_0_0",
        "photo_1_1_0",
        "photo_2_0_0",
    ]
    sides = [picture(blocks, b).shape[:2] for b in blocks.all() if b.level == 0]
    assert sum(h * w for h, w in sides) == SIZE[0] * SIZE[1]
    assert picture(blocks, Block(2, 0, 0)).shape[:2] == (325, 625)
    assert Blocks(folder, (BLOCK_PX, BLOCK_PX)).levels == 1


@pytest.mark.parametrize("block", [Block(0, 1, 1), Block(1, 0, 0), Block(2, 0, 0)])
def test_a_block_shows_its_part_of_the_picture(folder: Path, block: Block) -> None:
    found = picture(Blocks(folder, SIZE), block)
    step, size = 1 << block.level, BLOCK_PX << block.level
    h, w = found.shape[:2]
    x = block.column * size + step * (np.arange(w) + 0.5)
    z = block.row * size + step * (np.arange(h) + 0.5)
    seen = x < 2000 - step
    assert np.abs(found[:, seen, 0] - x[seen][None] // 10).max() < 12  # JPEG
    assert np.abs(found[:, seen, 1] - z[:, None] // 10).max() < 12
    assert found[:, x > 2000 + step].min(initial=255) > 240  # no data is white


def test_a_missing_band_is_told(folder: Path) -> None:
    with pytest.raises(FileError, match=r"depth\.tif: does not exist"):
        Blocks(folder, SIZE).band("depth", Block(0, 0, 0))
