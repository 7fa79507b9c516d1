"""The homography: from the pose, from pairs, and against the full projection."""

import cv2
import numpy as np
import pytest

import ortho_wall as wall
from frontage.errors import InputError
from frontage.geometry.homography import apply_homography, homography_from_pairs
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.project import full_projection, plane_homography


def test_pose_homography_is_the_full_projection_of_an_undistorted_camera():
    facade = wall.facade(30.0, 15.0)
    raster = facade_raster(facade, OrthoOptions())
    photo = wall.photo(facade, wall.camera(4000, 3000, distorted=False), (-6.0, -18.0, -5.0))
    c, r = np.meshgrid(np.linspace(0, raster.width, 60), np.linspace(0, raster.height, 40))
    by_plane = apply_homography(
        plane_homography(photo, facade, raster), np.column_stack([c.ravel(), r.ravel()])
    )
    by_rays = full_projection(photo, facade, raster)(c.ravel(), r.ravel(), 0.0)
    assert np.isfinite(by_plane).all()
    assert np.abs(by_plane - by_rays).max() < 0.01


def test_four_pairs_are_fitted_exactly_and_more_in_the_mean():
    H = np.array([[1.3, 0.1, 400.0], [-0.05, 1.2, 300.0], [2e-5, -1e-5, 1.0]])
    corners = np.array([[0, 0], [3000, 0], [3000, 1500], [0, 1500.0]])
    assert np.allclose(homography_from_pairs(corners, apply_homography(H, corners)), H, rtol=1e-9, atol=1e-12)
    rng = np.random.default_rng(0)
    many = rng.uniform(0, 3000, (400, 2))
    noisy = apply_homography(H, many) + rng.normal(0, 0.5, (400, 2))
    found = homography_from_pairs(many, noisy)
    error = np.linalg.norm(apply_homography(found, corners) - apply_homography(H, corners), axis=1)
    assert error.max() < 0.5
    theirs, _ = cv2.findHomography(many, noisy, 0)
    assert np.abs(apply_homography(theirs, corners) - apply_homography(found, corners)).max() < 0.2


def test_pairs_that_determine_no_homography_are_refused():
    line = np.column_stack([np.arange(6.0), 2 * np.arange(6.0)])
    with pytest.raises(InputError, match="three lie on a line"):
        homography_from_pairs(line, line)
    with pytest.raises(InputError, match="at least 4"):
        homography_from_pairs(line[:3], line[:3])
