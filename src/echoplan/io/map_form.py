"""What a ``map.json`` may hold."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from echoplan.arrays import FloatArray
from echoplan.io.structure import Count, Form, Pair
from echoplan.io.units import Coordinate, Radians, Radius, Variance, check_extent
from echoplan.model import (
    Changes,
    ClassProbabilities,
    Corner,
    CornerKind,
    Cylinder,
    FeatureClass,
    FeatureMap,
    Opening,
    Quality,
    UnobservedStretch,
    Verdict,
    Wall,
)

__all__ = ["MapForm"]

_Matrix2 = Annotated[
    list[Annotated[list[Variance], Field(min_length=2, max_length=2)]], Field(min_length=2, max_length=2)
]
_Matrix3 = Annotated[
    list[Annotated[list[Variance], Field(min_length=3, max_length=3)]], Field(min_length=3, max_length=3)
]
_Length = Annotated[Radius, Field(ge=0.0)]
_Loss = Annotated[float, Field(ge=0.0, le=200.0, allow_inf_nan=False)]


class _ProbabilitiesForm(Form):
    wall: float = Field(default=0.0, description="Probability that the feature is a wall.")
    corner: float = Field(default=0.0, description="Probability that the feature is a corner.")
    cylinder: float = Field(default=0.0, description="Probability that the feature is a cylinder.")

    def value(self) -> ClassProbabilities:
        """Make the probabilities."""
        return ClassProbabilities(**self.model_dump())


_Likelihood = Annotated[_ProbabilitiesForm | None, Field(description="Class probabilities of the feature.")]
_Pings = Annotated[Count, Field(description="Number of pings that support the feature.")]
_Stations = Annotated[Count, Field(description="Number of stations that detected the feature.")]
_Neighbours = Annotated[
    list[Count],
    Field(description="List of the walls on both sides, by their places in the list of walls, counted from 0."),
]


class _WallForm(Form):
    start: Pair = Field(description="First end [x, y] in metres.")
    end: Pair = Field(description="Second end [x, y] in metres.")
    normal_angle: Radians = Field(description="Direction of the normal of the wall [rad].")
    offset: Coordinate = Field(description="Distance of the wall from the origin along its normal [m].")
    covariance: _Matrix2 = Field(description="Covariance of normal_angle and offset (2 x 2).")
    class_probabilities: _Likelihood = None
    pings: _Pings = 0
    stations: _Stations = 0
    endpoint_sigmas: list[_Length | None] = Field(
        default=[None, None],
        min_length=2,
        max_length=2,
        description="Standard deviations of start and end along the wall [m], null where not estimated.",
    )
    inferred: list[_Length] = Field(
        default=[0.0, 0.0],
        min_length=2,
        max_length=2,
        description="Lengths at start and end over which the wall is extrapolated [m].",
    )
    reflection_loss: _Loss = Field(
        default=0.0, description="How much fainter than a hard wall the wall reflects sound [dB]."
    )

    def value(self) -> Wall:
        """Make the wall."""
        return Wall(
            normal_angle=self.normal_angle,
            offset=self.offset,
            endpoints_xy=np.array([self.start, self.end]),
            covariance=np.array(self.covariance),
            endpoint_sigmas=np.array(self.endpoint_sigmas, dtype=np.float64),
            inferred=np.array(self.inferred),
            reflection_loss=self.reflection_loss,
            **_evidence_in(self, FeatureClass.WALL),
        )


class _CornerForm(Form):
    position: Pair = Field(description="Vertex of the corner [x, y] in metres.")
    kind: Literal["concave", "convex"] = Field(
        description="Shape of the corner as seen from the stations that detected it."
    )
    covariance: _Matrix2 = Field(description="Covariance of x and y (2 x 2).")
    class_probabilities: _Likelihood = None
    pings: _Pings = 0
    stations: _Stations = 0

    def value(self) -> Corner:
        """Make the corner."""
        return Corner(
            position_xy=np.array(self.position),
            kind=CornerKind(self.kind),
            covariance=np.array(self.covariance),
            **_evidence_in(self, FeatureClass.CORNER),
        )


class _CylinderForm(Form):
    center: Pair = Field(description="Axis of the cylinder [x, y] in metres.")
    radius: Radius = Field(description="Radius of the cylinder [m].")
    covariance: _Matrix3 = Field(description="Covariance of x, y and radius (3 x 3).")
    class_probabilities: _Likelihood = None
    pings: _Pings = 0
    stations: _Stations = 0

    def value(self) -> Cylinder:
        """Make the cylinder."""
        return Cylinder(
            center_xy=np.array(self.center),
            radius=self.radius,
            covariance=np.array(self.covariance),
            **_evidence_in(self, FeatureClass.CYLINDER),
        )


def _evidence_in(form: _WallForm | _CornerForm | _CylinderForm, kind: FeatureClass) -> dict[str, Any]:
    certain = _ProbabilitiesForm(**{kind: 1.0})
    return {
        "class_probabilities": (form.class_probabilities or certain).value(),
        "pings": form.pings,
        "stations": form.stations,
    }


class _OpeningForm(Form):
    start: Pair = Field(description="First jamb of the opening [x, y] in metres.")
    end: Pair = Field(description="Second jamb of the opening [x, y] in metres.")
    width_sigma: _Length = Field(description="Standard deviation of the width of the opening [m].")
    walls: _Neighbours = Field(default=[])
    passed: bool = Field(default=False, description="Whether the robot drove through the opening.")

    def value(self) -> Opening:
        """Make the opening."""
        return Opening(
            endpoints_xy=np.array([self.start, self.end]),
            width_sigma=self.width_sigma,
            walls=tuple(self.walls),
            passed=self.passed,
        )


class _UnobservedForm(Form):
    start: Pair = Field(description="First end [x, y] in metres.")
    end: Pair = Field(description="Second end [x, y] in metres.")
    walls: _Neighbours = Field(default=[])

    def value(self) -> UnobservedStretch:
        """Make the stretch."""
        return UnobservedStretch(endpoints_xy=np.array([self.start, self.end]), walls=tuple(self.walls))


class _PoseForm(Form):
    sweep: Count = Field(description="Number of the sweep.")
    x: Coordinate = Field(description="Position of the robot [m].")
    y: Coordinate = Field(description="Position of the robot [m].")
    yaw: Radians = Field(description="Heading of the robot [rad].")
    covariance: _Matrix3 | None = Field(default=None, description="Covariance of x, y and yaw (3 x 3).")


class _QualityForm(Form):
    verdict: Literal["good", "doubtful", "failed"] = Field(description="Whether the map can be trusted.")
    reasons: list[str] = Field(default=[], description="List of sentences with the reasons of the verdict.")
    next_step: str = Field(default="", description="Next step to improve the map.")

    def value(self) -> Quality:
        """Make the quality."""
        return Quality(verdict=Verdict(self.verdict), reasons=tuple(self.reasons), next_step=self.next_step)


class _PieceForm(Form):
    start: Pair = Field(description="First end [x, y] in metres.")
    end: Pair = Field(description="Second end [x, y] in metres.")


class _ChangedForm(Form):
    walls: list[_PieceForm] = Field(default=[], description="List of walls, or of pieces of walls.")
    cylinders: list[_CylinderForm] = Field(default=[], description="List of cylinders.")

    def ends(self) -> tuple[FloatArray, ...]:
        """Return the ends of the walls [m]."""
        return tuple(np.array([wall.start, wall.end]) for wall in self.walls)


class _ChangesForm(Form):
    recording: str = Field(default="", description="Name of the recording that was compared with those before it.")
    first_sweep: int | None = Field(default=None, description="Number of its first sweep in the list of poses.")
    gone: _ChangedForm = Field(default=_ChangedForm(), description="What is no longer there.")
    new: _ChangedForm = Field(default=_ChangedForm(), description="What was not there before.")

    def value(self) -> Changes:
        """Make the changes."""
        return Changes(
            recording=self.recording,
            first_sweep=self.first_sweep,
            gone_walls=self.gone.ends(),
            new_walls=self.new.ends(),
            gone_cylinders=tuple(each.value() for each in self.gone.cylinders),
            new_cylinders=tuple(each.value() for each in self.new.cylinders),
        )


class MapForm(Form):
    """A map as JSON; what it does not name is passed over."""

    format: Literal["echoplan-map/1"] = Field(description="Version of the format, echoplan-map/1.")
    frame: str = Field(default="map", description="Frame of all coordinates.")
    method: str = Field(default="", description="Name of the method that made the map.")
    parameters: dict[str, Any] = Field(default={}, description="Settings of the run.")
    walls: list[_WallForm] = Field(default=[], description="List of walls.")
    corners: list[_CornerForm] = Field(default=[], description="List of corners.")
    cylinders: list[_CylinderForm] = Field(default=[], description="List of cylinders.")
    poses: list[_PoseForm] = Field(default=[], description="List of poses, one for each sweep.")
    openings: list[_OpeningForm] = Field(default=[], description="List of openings between walls.")
    unobserved: list[_UnobservedForm] = Field(
        default=[], description="List of pieces of wall that no station observed."
    )
    quality: _QualityForm | None = Field(default=None, description="Whether the map can be trusted.")
    changes: list[_ChangesForm] = Field(
        default=[], description="List of changes, for each recording that others came before."
    )

    @field_validator("openings", "unobserved", mode="after")
    @classmethod
    def _refers_to_walls_of_the_map(
        cls, gaps: Sequence[_OpeningForm | _UnobservedForm], info: ValidationInfo
    ) -> Sequence[_OpeningForm | _UnobservedForm]:
        # Walls that are at fault themselves are not in the data, and pydantic reports them.
        count = len(info.data["walls"]) if "walls" in info.data else None
        for number, gap in enumerate(gaps):
            wall = max(gap.walls, default=-1)
            if count is not None and wall >= count:
                problem = f"entry {number} refers to wall {wall}, but the number of walls is {count}"
                raise ValueError(f"{problem}; use their places in the list of walls, counted from 0")
        return gaps

    def _ends(self) -> Iterator[list[float]]:
        long: tuple[_WallForm | _OpeningForm | _UnobservedForm, ...] = (*self.walls, *self.openings, *self.unobserved)
        for each in long:
            yield each.start
            yield each.end

    def _places(self) -> Iterator[list[float]]:
        yield from (corner.position for corner in self.corners)
        yield from (cylinder.center for cylinder in self.cylinders)
        yield from ([pose.x, pose.y] for pose in self.poses)

    def value(self) -> FeatureMap:
        """Make the map."""
        check_extent([*self._ends(), *self._places()], name="the map")
        return FeatureMap(
            method=self.method,
            walls=tuple(wall.value() for wall in self.walls),
            corners=tuple(corner.value() for corner in self.corners),
            cylinders=tuple(cylinder.value() for cylinder in self.cylinders),
            sweeps=np.array([pose.sweep for pose in self.poses], dtype=np.int64),
            poses=np.reshape([[pose.x, pose.y, pose.yaw] for pose in self.poses], (-1, 3)),
            pose_covariances=np.reshape([pose.covariance for pose in self.poses if pose.covariance], (-1, 3, 3)),
            frame=self.frame,
            parameters=self.parameters,
            openings=tuple(map(_OpeningForm.value, self.openings)),
            unobserved=tuple(map(_UnobservedForm.value, self.unobserved)),
            quality=self.quality.value() if self.quality else None,
            changes=tuple(map(_ChangesForm.value, self.changes)),
        )
