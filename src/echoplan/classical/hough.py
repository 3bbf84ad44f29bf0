"""Hough votes of echoes for lines and points (Tardos, Neira, Newman and Leonard 2002)."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features import (
    AssemblySettings,
    Group,
    Grouped,
    Observation,
    Stack,
    assemble,
    cylinder_of,
    fit_line,
)
from echoplan.classical.loci import (
    Loci,
    Reflector,
    ReflectorKind,
    VoteSettings,
    echo_points,
    find_reflectors,
    observations_of_reflector,
)
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["HoughMapper", "HoughSettings"]

# Memberships in corner, cylinder and wall.
_DEGREES = {ReflectorKind.LINE: np.array([0.0, 0.0, 1.0]), ReflectorKind.POINT: np.array([0.5, 0.5, 0.0])}


class HoughSettings(Settings):
    """Settings of all stages of the Hough votes."""

    former_keys: ClassVar = {"common": "common_sigma"}

    votes: VoteSettings = Field(default_factory=VoteSettings)
    assembly: AssemblySettings = Field(default_factory=AssemblySettings)
    common_sigma: float = Field(
        default=0.005,
        ge=0.0,
        description="Standard deviation of the range error that all echoes of a wall share [m]: range walk of a "
        "step of a module.",
    )
    point_radius: float = Field(default=0.03, gt=0.0, description="Radius below which a circle is a corner [m].")


class HoughMapper:
    """Maps by the lines and points for which most echoes vote.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : HoughSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: HoughSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or HoughSettings()
        self._sweeps: list[Sweep] = []
        self._loci: list[Loci] = []

    def add(self, sweep: Sweep) -> None:
        """Draw the arcs of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._loci.append(Loci.of(sweep, self.rig))
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Count the votes of all echoes and map the winners.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        loci = Loci.joined(self._loci)
        return assemble(
            self.group(find_reflectors(loci, self.settings.votes), loci),
            self._sweeps,
            self.settings.assembly,
            method="hough",
            parameters=self.settings.model_dump(mode="json"),
        )

    def group(self, reflectors: list[Reflector], loci: Loci) -> Grouped:
        """Classify reflectors as walls, corners and cylinders.

        Parameters
        ----------
        reflectors : list of Reflector
            Reflectors found by the votes.
        loci : Loci
            Arcs of all sweeps.

        Returns
        -------
        Grouped
            Lines are walls; points are classified by the radius of the circle that their echoes touch.
        """
        members_of_kind = {
            kind: [observations_of_reflector(each, loci, degrees=degrees) for each in reflectors if each.kind is kind]
            for kind, degrees in _DEGREES.items()
        }
        points = [tuple(members) for members in members_of_kind[ReflectorKind.POINT]]
        round_ones = [members for members in points if self._radius(members) > self.settings.point_radius]
        return Grouped(
            lines=[self._wall(members) for members in members_of_kind[ReflectorKind.LINE]],
            corners=[each for members in points if members not in round_ones for each in members],
            cylinders=round_ones,
        )

    @property
    def points_xy(self) -> FloatArray:
        """Where on their arcs the echoes of the winners come from [m], shape (n, 2)."""
        loci = Loci.joined(self._loci)
        reflectors = find_reflectors(loci, self.settings.votes)
        return np.concatenate([np.zeros((0, 2)), *(echo_points(each, loci) for each in reflectors)])

    def _wall(self, members: list[Observation]) -> Group:
        gates = self.settings.assembly.association
        fit = fit_line(Stack.of(members, floor=(gates.common_bearing_sigma, gates.common_distance_sigma)))
        shared = np.diag([0.0, self.settings.common_sigma**2])
        return Group(members=tuple(members), fit=replace(fit, covariance=fit.covariance + shared))

    def _radius(self, members: tuple[Observation, ...]) -> float:
        assembly = self.settings.assembly
        cylinder = cylinder_of(members, assembly.cylinders, association=assembly.association)
        return 0.0 if cylinder is None else cylinder.radius
