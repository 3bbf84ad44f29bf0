"""All stations at once: rival reflectors, judged by what a sonar should hear of them, and one adjustment of all.

A wall is a line that touches the range circles of its stations, a corner or an edge a point on them, a cylinder one
that touches them (Leonard and Durrant-Whyte 1992).  A physical model of loudness, beam, masking and range walk says
which of these explains the pings, including those that are missing.
"""

import copy

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.mapping.account import Account, AccountSettings, PoseMode
from echoplan.mapping.certainty import carried_covariances
from echoplan.mapping.poses import odometry_beliefs, waypoint_beliefs
from echoplan.mapping.tracking import track
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.preprocessing.soundings import Soundings, join_soundings, soundings_of
from echoplan.preprocessing.stations import at_stations, group_sweeps

__all__ = ["JointMapper", "JointSettings"]


# From fewer stations there is nothing to hold a pose against.
_FEWEST = 3


class JointSettings(AccountSettings, frozen=True, extra="forbid"):
    """Settings of all stages."""


class JointMapper:
    """Maps all stations at once.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : JointSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: JointSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or JointSettings()
        self._sweeps: list[Sweep] = []
        self._soundings: list[Soundings] = []

    def add(self, sweep: Sweep) -> None:
        """Take one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        if len(sweep):
            self._sweeps.append(sweep)
            self._soundings.append(soundings_of(sweep, self.rig))

    def result(self) -> FeatureMap:
        """Explain everything that was heard so far.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders, and the poses from which they were heard.
        """
        sweeps = np.array([sweep.index for sweep in self._sweeps], dtype=np.int64)
        given = np.array([sweep.station for sweep in self._sweeps]).reshape(-1, 3)
        parameters = self.settings.model_dump(mode="json")
        if not any(len(part.readings) for part in self._soundings):
            return FeatureMap(method="joint", parameters=parameters, sweeps=sweeps, poses=given)
        stations = group_sweeps(
            given, np.array([len(each.readings) for each in self._soundings]), self.settings.stations
        )
        found = self._account(at_stations(join_soundings(self._soundings), stations), stations.poses)
        survey, poses = found.survey(), stations.of_sweeps(given, found.poses)
        open_ways = [each.at_sweeps(stations, sweeps) for each in found.undetermined()]
        return FeatureMap(
            method="joint",
            parameters={**parameters, "found": {**found.calibration(), "undetermined": open_ways}},
            walls=survey.walls(),
            corners=survey.corners(),
            cylinders=survey.cylinders(),
            sweeps=sweeps,
            poses=poses,
            pose_covariances=carried_covariances(found.pose_covariances(), stations, poses),
        )

    def _account(self, heard: Soundings, given: FloatArray) -> Account:
        """Explain everything from the poses as they are, and from better ones if the pings disagree."""
        account, errors = Account(self.rig, heard, given, self.settings), self.settings.pose_errors
        mode = self.settings.poses
        account.glance()
        if mode is PoseMode.CORRECT or (mode is PoseMode.AUTO and account.is_torn()):
            track(account, odometry_beliefs(given, errors, self.rig.odometry))
            drifted = "corrected: from the poses as recorded most walls were there twice"
            account.verdict = "corrected, as asked for" if mode is PoseMode.CORRECT else drifted
            return account
        account.explain()
        return account if mode is PoseMode.TRUST else self._nudged(account)

    def _nudged(self, account: Account) -> Account:
        """Move poses a little if the pings do not agree and want the headings otherwise: way-points are set by eye.

        Headings that were measured stay where they are, and then what disagrees is no matter of poses.
        """
        share = f"{100 * account.agreement():.0f} % of the echoes agree from the poses as recorded"
        account.verdict = f"trusted: {share}"
        if account.agrees() or len(account.given) < _FEWEST:
            return account
        moved = copy.copy(account)
        moved.correct(waypoint_beliefs(account.given, self.settings.pose_errors))
        turned = float(np.abs(wrap(moved.poses[:, 2] - account.given[:, 2])).mean())
        moved.verdict = f"corrected by a few centimetres: only {share}"
        account.verdict = f"trusted: {share}, but their headings hardly move"
        return moved if turned > self.settings.turned else account
