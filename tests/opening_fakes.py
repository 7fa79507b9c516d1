"""Openings and protrusions written down by hand on the facade of `facade_fakes`."""

from dataclasses import replace

import numpy as np

from frontage.geometry.ring import rectangle
from frontage.model import Bar, Elements, Estimate, Glazing, Opening, Protrusion, Provenance


def opening(
    name: str = "B01/F1/W1-1", box: tuple[float, float, float, float] = (-3.1, -0.7, -1.9, 0.9)
) -> Opening:
    """Returns a window 12 cm deep with two bars, whose left, bottom, right and top borders have standard
    errors of 3, 4, 5 and 6 mm."""
    x0, z0, x1, z1 = box
    sigma = np.array([3, 4, 5, 4, 5, 6, 3, 6]) * 1e-3
    root = np.random.default_rng(4).normal(size=(8, 8))
    part = root @ root.T
    scale = sigma / np.sqrt(np.diag(part))
    return Opening(
        id=name,
        kind="window",
        ring=np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1]]),
        ring_covariance=part * np.outer(scale, scale),
        depth=Estimate(0.1 + 0.02, np.array([[0.007**2]]), 41.0, Provenance.POOLED),
        shape="rectangle",
        provenance=Provenance.MEASURED,
        evidence=212.125,
        confidence=0.9375,
        floor=1,
        bay=1,
        glazing=Glazing(
            resolved=True,
            bars=(
                Bar("vertical", -2.5, (-0.7, 0.9), 0.06, 0.004, 0.003),
                Bar("horizontal", 0.3, (-3.1, -1.9), 0.05, float("inf"), provenance=Provenance.POOLED),
            ),
            frame_width=Estimate(0.07, np.array([[0.004**2]]), 12.0),
            depth=Estimate(0.125, np.array([[0.003**2]]), 12.0, Provenance.POOLED),
            confidence=0.875,
            sources=("IMG_1.jpg", "scan"),
        ),
        photos=("IMG_1.jpg",),
    )


def round_door(name: str = "B01/F1/D0-1") -> Opening:
    """Returns an inferred door without a depth, whose round head has many corners."""
    angle = np.linspace(0, np.pi, 13)
    head = np.column_stack([2.0 + 0.6 * np.cos(angle), -1.2 + 0.6 * np.sin(angle)])
    ring = np.vstack([[[1.4, -3.0], [2.6, -3.0]], head])
    return replace(
        opening(),
        id=name,
        kind="door",
        ring=ring,
        ring_covariance=np.eye(2 * len(ring)) * 0.03**2,
        depth=None,
        shape="round",
        provenance=Provenance.INFERRED,
        floor=0,
        glazing=None,
        photos=(),
    )


def balcony() -> Protrusion:
    """Returns a balcony whose front lies 0.9 m before the wall with an unknown error."""
    front = Estimate(-0.9, np.array([[np.inf]]), float("inf"))
    return Protrusion(
        "B01/F1/P1", "balcony", rectangle(-3.3, -1.8, -1.7, -0.8), 0.02, front, Provenance.MEASURED, 0.8
    )


def on_balcony() -> Opening:
    """Returns a window in the front of `balcony`."""
    return replace(opening("B01/F1/W0-2", (-3.0, -1.7, -2.0, -0.9)), on="B01/F1/P1", floor=0, bay=2)


def elements() -> Elements:
    """A window, an inferred door, a balcony with a window in its front."""
    return Elements("B01/F1", (opening(), round_door(), on_balcony()), (balcony(),))
