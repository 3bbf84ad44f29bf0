"""Tracking: station after station, each placed against what the ones before it know of the room."""

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import compose, directions, invert
from echoplan.joint.arcs import arc_planes
from echoplan.joint.estimate import Account
from echoplan.joint.likelihood_cache import LikelihoodCache
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, continued, dead_reckoned
from echoplan.joint.pose_correction.annealing import settle
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, best_score, local_scans, locate
from echoplan.preprocessing.measurements import first_stations

__all__ = ["follow", "sights_of", "track", "until"]

# Where a station should be, by those before it that recognised the room: its pose and the deviations of that.
_Expected: TypeAlias = Callable[[FloatArray, int, Sequence[int]], tuple[FloatArray, FloatArray]]

# Arcs that no feature explains are known less well than features are.
_LOOSE = 0.5
# A cylinder that an arc may be [m].
_RADIUS = 0.1
# A station whose arcs are likely by this share of what they could be hears nothing new (logarithms).
_UNDERSTOOD = 0.6
# Part of a deviation of the heading that is searched at once.
_PART = 0.75
# Fewer stations do not know enough to place the first among them.
_FEW = 4
# Where the first station is, as well as its own arcs tell [m, m, rad]; it is moved only on strong evidence: this
# logarithm of a ratio of likelihoods [nats] (Kass and Raftery 1995).
_HERE, _STRONG = np.array([0.005, 0.005, math.radians(0.5)]), 3.0
# A station that is off by less has joined the others; more, and its walls are taken for other walls [m, rad].
_JOINED = (0.05, math.radians(3.0))


def track(account: Account, priors: PosePrior) -> Account:
    """Correct the poses of an account that drift.

    Parameters
    ----------
    account : Account
        Everything that was heard, as recorded.
    priors : PosePrior
        Odometry.
    """
    reaches = priors.reaches

    def expected(poses: FloatArray, station: int, _: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        return dead_reckoned(account.given, poses, station), reaches[station]

    followed = follow(account, priors, expected)
    if account.memory.is_empty and len(account.given) > _FEW:
        followed = _join_first(followed, priors)
    return settle(followed, priors)


def follow(account: Account, priors: PosePrior, expected: _Expected) -> Account:
    """Follow the robot from station to station.

    Each station is looked for about where it is expected, by its arcs against the features so far and the arcs that
    belong to none; then features and poses of all stations so far are adjusted together, unless this one hears little
    that is new.

    Parameters
    ----------
    account : Account
        Everything that was heard, as recorded.
    priors : PosePrior
        Steps from station to station.
    expected : callable
        Returns where a station should be [m, m, rad], from the poses so far and the stations that recognised the room.

    Returns
    -------
    Account
        With poses of all stations and the features that they detected.
    """
    # What a first look learned of the sonar it learned from poses in error.
    account = replace(
        account.with_squareness(None).restart_servo(),
        model=account.memory.model or account.prior,
        adjusted=None,
        loudness=account.memory.loudness,
        poses=continued(account.given, account.memory.poses),
        features=account.known,
    )
    sights, settings = sights_of(account), account.settings.localisation
    first = max(1, len(account.memory.poses))
    known, recognised = _known(account, first), list(range(first))
    for station in range(first, len(account.given)):
        guess, sigmas = expected(account.poses, station, recognised)
        pose, score = locate(sights[station], known, guess, 1.3 * sigmas, settings)
        account = replace(
            account, poses=np.concatenate([account.poses[:station], [pose], account.poses[station + 1 :]])
        )
        if score > VERY_STRONG:
            recognised.append(station)
        if score <= _UNDERSTOOD * best_score(sights[station], settings):
            part = _learn(account, priors, station + 1)
            poses = np.concatenate([part.poses, account.poses[station + 1 :]])
            account, known = replace(account, poses=poses, features=part.features), _catalogue(part)
    return account


def sights_of(account: Account) -> list[LocalScan]:
    """See with the arcs of each station.

    Parameters
    ----------
    account : Account
        What was heard.

    Returns
    -------
    list of LocalScan
        By station.
    """
    hearing, arcs = account.model.tabulated(), defaultdict(list)
    for arc in account.arcs:
        arcs[arc.station].append(arc)
    return [local_scans(arcs[station], account.recorded, hearing, pose) for station, pose in enumerate(account.given)]


def _join_first(account: Account, priors: PosePrior) -> Account:
    """Look for the first station in what the others know, and move these to where it should be.

    The second was placed against the arcs of a single station, of which any may be a wall, a corner or a cylinder.  If
    it was misplaced, all others fit together and the first stands alone.
    """
    sight = sights_of(account)[0]
    others = LandmarkMap.of([each for each in account.features if each.llr_by_station[1:].max(initial=0.0) > 0.0])
    back = invert(compose(invert(account.given[0]), account.given[1]))
    way, sigmas = float(np.hypot(back[0], back[1])), 1.3 * priors.reaches[1]
    # An error of the second heading turns the way back: each part of it is searched with what it leaves open.
    rest = np.hypot(sigmas, [0.5 * way * _PART * sigmas[2]] * 2 + [0.0]) * [1.0, 1.0, _PART]
    _, score = locate(sight, others, account.poses[0], _HERE, account.settings.localisation)
    found, most = account.poses[0], score + _STRONG
    for turn in np.arange(-3.0, 3.0 + _PART, _PART):
        guess = compose(compose(account.poses[1], [0.0, 0.0, turn * sigmas[2]]), back)
        pose, score = locate(sight, others, guess, rest, account.settings.localisation)
        if score - 0.5 * turn**2 > most:
            found, most = pose, score - 0.5 * turn**2
    off = compose(invert(account.poses[0]), found)
    if math.hypot(off[0], off[1]) <= _JOINED[0] and abs(off[2]) <= _JOINED[1]:
        return account
    joined = compose(compose(account.poses[0], invert(found)), account.poses[1:])
    return replace(account, poses=np.concatenate([account.poses[:1], joined]), features=account.known)


def until(account: Account, count: int) -> Account:
    """Keep an account of the first stations only, with the poses and features of now.

    Parameters
    ----------
    account : Account
        An account, which stays as it is.
    count : int
        How many stations.

    Returns
    -------
    Account
        Another one.
    """
    recorded = first_stations(account.recorded, count)
    given, poses = account.given[:count], account.poses[:count]
    return replace(
        account,
        recorded=recorded,
        given=given,
        poses=poses,
        measurements=at_poses(recorded, given, poses),
        arcs=[arc for arc in account.arcs if arc.station < count],
        likelihoods=LikelihoodCache(),
    )


def _known(account: Account, count: int) -> LandmarkMap:
    """List what is known before anything is learned from the first stations."""
    part = until(account, count)
    return _catalogue(replace(part, features=part.refreshed()))


def _learn(account: Account, priors: PosePrior, count: int) -> Account:
    """Find features from the first stations, and adjust their poses with them."""
    part = replace(until(account, count), noise=account.settings.pose_errors.tracking_noise).search(rounds=1)
    first = priors._replace(given=priors.given[:count], sigmas=priors.sigmas[:count])
    return part.alternate(part.noise, first, 2)


def _catalogue(known: Account) -> LandmarkMap:
    """List features, and arcs that belong to none as walls, corners and cylinders."""
    features, explained = known.features, known.explained(known.features)
    loose = [arc for arc in known.arcs if arc.share_of(explained) < 0.5]
    sure = LandmarkMap.of(features)
    rows, extents = list(sure.reflectors), list(sure.extents)
    if loose:
        planes = arc_planes(loose, known.measurements, known.model.tabulated())
        for arc, (normal, offset) in zip(loose, planes, strict=True):
            center = known.measurements.centers[arc.station]
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
    return LandmarkMap(np.array(rows).reshape(-1, 4), weights, np.array(extents).reshape(-1, 2))
