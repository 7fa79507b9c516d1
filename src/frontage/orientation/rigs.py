"""Rigs among photos: which body carries each photo, where bodies are, and photos that only a rig places."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, rotation_angle, skew
from frontage.model import Estimate, Exposure, Photo, Provenance, Rig
from frontage.orientation.adjustment import Adjustment, Photos, held_mount
from frontage.orientation.result import OrientedPhoto

_SHOWN = 3  # photos named in a note
_FREE = np.diag(np.full(6, np.inf))
_APART_M, _APART_RAD = 0.5, np.radians(3.0)  # from where its rig puts a photo: another place, not an error

Mount = Estimate[Rigid3]
"""body_from_camera, with covariance zero where it is exact, and inf where nothing is known of it."""


@dataclass(frozen=True, eq=False)
class Carriers:
    """The bodies of photos, and how the photos sit on them.

    photos  for the adjustment; its first mount is that of photos on no rig
    bodies  local_from_body of its b bodies
    """

    photos: Photos
    bodies: tuple[Rigid3, ...]

    def priors(self, given: Sequence[Estimate[Rigid3] | None]) -> tuple[Estimate[Rigid3] | None, ...]:
        """What is known beforehand of every body, from what is known of its photos.

        The poses that cameras of one exposure report are one piece of knowledge, and not several: they are
        averaged, and keep the covariance of a single one.
        """
        parts: dict[int, list[Estimate[Rigid3]]] = defaultdict(list)
        for body, mount, pose in zip(self.photos.body, self.photos.mount, given, strict=True):
            mounted = self.photos.mounts[mount]
            if pose is not None and np.isfinite(mounted.covariance).all():
                parts[int(body)].append(body_of(pose, mounted))
        return tuple(_one_of(parts[k]) if k in parts else None for k in range(len(self.bodies)))


def carriers_of(photos: Sequence[Photo], cameras: Sequence[int], rigs: Sequence[Rig]) -> Carriers:
    """Finds the bodies of photos with approximate poses; `cameras` are the numbers of their cameras.

    The photos of one exposure share a body. So does a camera whose place on the body nothing states, as soon
    as another camera of one of its exposures has a pose. All other photos are their own bodies.
    """
    poses = {photo.id: photo.pose for photo in photos}
    mounts = [held_mount()]
    on: dict[str, tuple[tuple[int, int], int]] = {}
    for r, rig in enumerate(rigs):
        known = mounts_of(rig, poses)
        numbers = {}
        for camera, mount in known.items():
            numbers[camera] = len(mounts)
            mounts.append(mount)
        for e, exposure in enumerate(rig.exposures):
            pairs = zip(exposure.photos, exposure.cameras, strict=True)
            on |= {name: ((r, e), numbers[camera]) for name, camera in pairs if camera in numbers}
    number: dict[object, int] = {}
    carried = [on.get(photo.id, (photo.id, 0)) for photo in photos]
    body = [number.setdefault(key, len(number)) for key, _ in carried]
    sits = [number for _, number in carried]
    made = Photos(np.array(body, np.int64), np.array(cameras), np.array(sits, np.int64), tuple(mounts))
    at: dict[int, list[Rigid3]] = defaultdict(list)
    for photo, b, m in zip(photos, body, sits, strict=True):
        at[b].append(photo.pose.after(mounts[m].value.inverse))
    return Carriers(made, tuple(mean_pose(at[b]) for b in range(len(at))))


def mounts_of(rig: Rig, poses: Mapping[str, Rigid3]) -> dict[int, Mount]:
    """How the cameras of a rig are mounted, by their numbers; `poses` are those of photos so far.

    Places that the rig does not state come from exposures with a camera whose place is known; cameras of
    which nothing can be told are left out. Where no place is stated, the first camera is the body.
    """
    stated = {k: c.body_from_camera for k, c in enumerate(rig.cameras)}
    known = {k: mount for k, mount in stated.items() if mount is not None} or {0: held_mount()}
    while True:
        found: dict[int, list[Rigid3]] = defaultdict(list)
        for exposure in rig.exposures:
            pairs = zip(exposure.photos, exposure.cameras, strict=True)
            there = {camera: poses[name] for name, camera in pairs if name in poses}
            held = [pose.after(known[k].value.inverse) for k, pose in there.items() if k in known]
            for camera in there.keys() - known.keys() if held else ():
                found[camera].append(mean_pose(held).inverse.after(there[camera]))
        if not found:
            return known
        known |= {k: Estimate(mean_pose(parts), _FREE, 0.0) for k, parts in found.items()}


def body_of(pose: Estimate[Rigid3], mount: Mount) -> Estimate[Rigid3]:
    """The pose of a body from that of a camera on it; the errors of both are independent."""
    body = pose.value.after(mount.value.inverse)
    carried, turned = np.eye(6), np.kron(np.eye(2), body.R)
    carried[:3, 3:] = skew(body.rotate(mount.value.t[None])[0])
    own = carried @ turned
    covariance = carried @ pose.covariance @ carried.T + own @ mount.covariance @ own.T
    return Estimate(body, covariance, pose.dof, pose.provenance)


def _one_of(poses: Sequence[Estimate[Rigid3]]) -> Estimate[Rigid3]:
    covariance = np.mean([pose.covariance for pose in poses], axis=0)
    return Estimate(mean_pose([p.value for p in poses]), covariance, poses[0].dof, poses[0].provenance)


def mean_pose(poses: Sequence[Rigid3]) -> Rigid3:
    """The mean position, and the chordal mean of the rotations."""
    R = Rotation.from_matrix([pose.R for pose in poses]).mean().as_matrix()
    return Rigid3(poses[0].to, poses[0].frm, R, np.mean([pose.t for pose in poses], axis=0))


def consistent_poses(
    rigs: Sequence[Rig], placed: Mapping[str, tuple[Photo, float]], given: Mapping[str, Photo]
) -> dict[str, Photo]:
    """Puts the photos of every exposure on one body, also those that have no place of their own.

    placed  photos with a place, and how far it is to be relied on: the larger number wins where places of one
            exposure contradict one another
    given   all photos

    Returns the photos that a rig places, by their ids; those of exposures without any place are missing.
    """
    out: dict[str, Photo] = {}
    poses = {name: photo.pose for name, (photo, _) in placed.items()}
    for rig in rigs:
        mounts = mounts_of(rig, poses)
        for exposure in rig.exposures:
            pairs = zip(exposure.photos, exposure.cameras, strict=True)
            on = {name: mounts[k].value for name, k in pairs if k in mounts and name in given}
            bodies = {name: poses[name].after(on[name].inverse) for name in on if name in poses}
            if not bodies:
                continue
            body = _agreed(list(bodies.values()), np.array([placed[name][1] for name in bodies]))
            for name, mount in on.items():
                photo = placed[name][0] if name in placed else given[name]
                pose = Estimate(body.after(mount), np.zeros((6, 6)), 0.0, Provenance.MEASURED)
                out[name] = replace(photo, local_from_camera=pose)
    return out


def apart(a: Rigid3, b: Rigid3) -> bool:
    """Whether two poses of one camera are different places, and not one place with errors."""
    far = float(np.linalg.norm(a.t - b.t)) > _APART_M
    return far or rotation_angle(a.R.T @ b.R) > _APART_RAD


def _agreed(bodies: list[Rigid3], weight: Float) -> Rigid3:
    """The mean of the poses that agree with the one that most weight agrees with."""
    agree = np.array([[not apart(a, b) for b in bodies] for a in bodies])
    best = int((agree @ weight).argmax())
    return mean_pose([body for body, good in zip(bodies, agree[best], strict=True) if good])


def adjusted_rigs(rigs: Sequence[Rig], names: Sequence[str], found: Adjustment) -> tuple[Rig, ...]:
    """The rigs of the adjusted photos `names`, with the mounts and the exposures that were adjusted.

    Cameras of which no photo was oriented keep what is stated of them.
    """
    number = {name: k for k, name in enumerate(names)}
    out = []
    for rig in rigs:
        cameras, exposures = list(rig.cameras), []
        for exposure in rig.exposures:
            pairs = zip(exposure.photos, exposure.cameras, strict=True)
            there = [(p, k) for p, k in pairs if p in number and found.photos.mount[number[p]] > 0]
            for photo, k in there:
                mount = found.mounts[found.photos.mount[number[photo]]]
                cameras[k] = replace(cameras[k], body_from_camera=mount)
            if there:
                exposures.append(Exposure(exposure.name, *(tuple(part) for part in zip(*there, strict=True))))
        if exposures:
            out.append(Rig(rig.name, tuple(cameras), tuple(exposures)))
    return tuple(out)


def rig_notes(photos: Sequence[OrientedPhoto]) -> tuple[str, ...]:
    """Says which photos their rig alone orients."""
    carried = [p.photo.id for p in photos if p.verdict == "carried"]
    if not carried:
        return ()
    more = f" and {len(carried) - _SHOWN} more" if len(carried) > _SHOWN else ""
    names = ", ".join(carried[:_SHOWN]) + more
    return (f"too little is seen by {names}: the other cameras of their rig tell their poses",)
