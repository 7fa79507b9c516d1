"""A facade's plane from a cloud that is mostly clutter.

Sixty per cent of the points are not on the wall. The script prints the offset and the angle from the true
plane beside the standard errors that Frontage reports, and the same for the published 3-point RANSAC.
"""

import numpy as np

import frontage
from frontage.facades import FacadeOptions
from frontage.geometry.rigid import Rigid3
from frontage.model import Building, Scan, WorldRef

WIDTH, HEIGHT, SPACING, NOISE, CLUTTER = 20.0, 12.0, 0.04, 0.005, 0.6  # m, m, m, m, share of the points
AZIMUTH = 0.4  # radians: the direction in which the wall runs


def true_frame() -> Rigid3:
    """The facade frame of the wall: X along it, Y into the building, Z up, at its lower left corner."""
    c, s = np.cos(AZIMUTH), np.sin(AZIMUTH)
    return Rigid3("local", "facade", np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))


def simulated_wall(seed: int = 1) -> Scan:
    """Points on the wall with noise along the beam, and clutter around it, seen from one station."""
    rng = np.random.default_rng(seed)
    x, z = np.meshgrid(np.arange(0, WIDTH, SPACING), np.arange(0, HEIGHT, SPACING))
    wall = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    low, high = (0.0, -3.0, 0.0), (WIDTH, 4.0, HEIGHT)
    clutter = rng.uniform(low, high, (round(len(wall) * CLUTTER / (1 - CLUTTER)), 3))
    ground = np.column_stack([rng.uniform(0, WIDTH, 4000), rng.uniform(-6, 0, 4000), np.zeros(4000)])
    points = np.concatenate([wall, clutter, ground])
    station = np.array([[WIDTH / 2, -12.0, 1.8]])
    beam = points - station
    beam /= np.linalg.norm(beam, axis=1, keepdims=True)
    points = points + rng.normal(0.0, NOISE, (len(points), 1)) * beam
    frame = true_frame()
    return Scan(
        "wall",
        frame.apply(points),
        WorldRef((691_000, 5_334_000, 520), "EPSG:25832"),
        origins=frame.apply(station),
        origin_index=np.zeros(len(points), np.int32),
    )


def main() -> None:
    scan, true = simulated_wall(), true_frame()
    building = Building("B01", np.arange(len(scan)), ground_z=0.0)
    share = 100 * CLUTTER
    print(f"{len(scan)} points, {share:.0f} % of them clutter, 5 mm noise; wall {WIDTH:g} x {HEIGHT:g} m")
    print(f"{'method':10}{'offset':>12}{'its sigma':>12}{'angle':>14}{'its sigma':>12}")
    for method in ("lo-msac", "paper"):
        facade = frontage.find_facades(scan, building, FacadeOptions(method=method))[0]
        if not facade:
            raise SystemExit(facade.message)
        offset = true.inverse.apply(facade.frame.t[None])[0, 1]  # from the true plane to the barycentre
        turn = np.linalg.norm(np.cross(facade.frame.R[:, 1], true.R[:, 1]))
        sigma = facade.local_from_facade.sigma
        angles = f"{np.degrees(turn):>10.4f} deg{np.degrees(np.hypot(sigma[3], sigma[5])):>8.4f} deg"
        print(f"{method:10}{offset * 1000:>9.2f} mm{sigma[1] * 1000:>9.2f} mm{angles}")


if __name__ == "__main__":
    main()
