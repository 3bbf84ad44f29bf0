"""Tracking: station after station, each placed against what the ones before it know of the room."""

import numpy as np

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray
from echoplan.extraction.arcs import arc_planes
from echoplan.geometry import compose, directions, invert
from echoplan.mapping.account import Account
from echoplan.mapping.localisation import Catalogue, Sightline, locate, sightlines
from echoplan.mapping.poses import PoseBeliefs, continued

__all__ = ["track"]

# Arcs that no feature explains are known less well than features are.
_LOOSE = 0.5
# A cylinder that an arc may be [m].
_RADIUS = 0.1


def track(account: Account, beliefs: PoseBeliefs) -> None:
    """Correct the poses of an account that drift.

    Each station is looked for about where odometry says it is, by its arcs against the features so far and the arcs
    that belong to none; then features and poses of all stations so far are adjusted together.

    Parameters
    ----------
    account : Account
        Everything that was heard, as recorded; changed in place.
    beliefs : PoseBeliefs
        Odometry.
    """
    # What a first look learned of the sonar it learned from poses in error.
    account.model, account.adjusted = account.memory.model or account.prior, None
    sights = _sights(account)
    account.poses, account.features = continued(account.given, account.memory.poses).copy(), account.known
    for station in range(max(1, len(account.memory.poses)), len(account.given)):
        known = account.until(station)
        guess = _next(account, station)
        pose, _ = locate(
            sights[station], _catalogue(known), guess, 1.3 * beliefs.sigmas[station], account.settings.localisation
        )
        account.poses[station] = pose
        _learn(account, beliefs, station + 1)
    account.settle(beliefs)


def _sights(account: Account) -> list[Sightline]:
    hearing = account.model.tabulated()
    return [
        sightlines([arc for arc in account.arcs if arc.station == station], account.recorded, hearing, pose)
        for station, pose in enumerate(account.given)
    ]


def _next(account: Account, station: int) -> FloatArray:
    step = compose(invert(account.given[station - 1]), account.given[station])
    pose: FloatArray = compose(account.poses[station - 1], step)
    return pose


def _learn(account: Account, beliefs: PoseBeliefs, count: int) -> None:
    """Find features from the first stations, and adjust their poses with them."""
    part = account.until(count)
    part.noise = account.settings.pose_errors.tracking_noise
    part.search(rounds=1)
    first = beliefs._replace(given=beliefs.given[:count], sigmas=beliefs.sigmas[:count])
    for _ in range(2):
        part.adjust(part.noise, first)
        part.judge(part.noise)
    account.poses[:count] = part.poses
    account.features = part.features


def _catalogue(known: Account) -> Catalogue:
    """List features, and arcs that belong to none as walls, corners and cylinders."""
    features = known.refreshed()
    explained = known.explained(features)
    loose = [arc for arc in known.arcs if explained[arc.pings].mean() < 0.5]
    rows = [each.reflector for each in features]
    extents = [each.extent for each in features]
    if loose:
        planes = arc_planes(loose, known.soundings, known.model.tabulated())
        for arc, (normal, offset) in zip(loose, planes, strict=True):
            center = known.soundings.centers[arc.station]
            along = float(center @ directions(normal + np.pi / 2))
            depth = offset - float(center @ directions(normal))
            point, behind = (center + away * directions(normal) for away in (depth, depth + _RADIUS))
            rows += [
                np.array([Kind.WALL, normal, offset, 0.0]),
                np.array([Kind.CORNER, *point, 0.0]),
                np.array([Kind.CYLINDER, *behind, _RADIUS]),
            ]
            extents += [(along, along), (0.0, 0.0), (0.0, 0.0)]
    weights = np.concatenate([np.ones(len(features)), np.full(len(rows) - len(features), _LOOSE)])
    return Catalogue(np.array(rows).reshape(-1, 4), weights, np.array(extents).reshape(-1, 2))
