"""Settings of all stages of the estimator."""

from enum import StrEnum
from typing import Annotated

from pydantic import AfterValidator, BaseModel, Field

from echoplan.acoustics.range_walk_model import WalkCurve
from echoplan.errors import EchoplanError
from echoplan.joint.arcs import ArcSettings
from echoplan.joint.map_extraction.corners import CornerSettings
from echoplan.joint.map_extraction.map_builder import MapSettings
from echoplan.joint.map_extraction.segments import SegmentSettings
from echoplan.joint.observability import ObservabilitySettings
from echoplan.joint.optimisation.manhattan import ManhattanSettings
from echoplan.joint.optimisation.odometry_noise import OdometryNoiseSettings
from echoplan.joint.optimisation.optimiser import OptimiserSettings
from echoplan.joint.optimisation.pose_factors import PoseSettings
from echoplan.joint.search.duplicates import DuplicateSettings
from echoplan.joint.search.scan_matching import LocalisationSettings
from echoplan.joint.search.search import SearchSettings
from echoplan.preprocessing.stations import StationSettings

__all__ = ["EstimateSettings", "PoseMode", "WindowSettings"]


# Models of the range walk that need no table.
_WALKS = ("physical", "fitted")


class PoseMode(StrEnum):
    """How recorded poses are used."""

    TRUST = "trust"
    CORRECT = "correct"
    AUTO = "auto"


class WindowSettings(BaseModel, frozen=True, extra="forbid"):
    """Number of stations that are optimised together."""

    stations: int = Field(default=24, ge=3, description="that stay at hand when others are let go")
    step: int = Field(default=12, ge=1, description="that are let go together")


def _falls(walk: str | tuple[tuple[float, float], ...]) -> str | tuple[tuple[float, float], ...]:
    """Return the range walk if it is one of the names or a valid table; raise ValueError otherwise."""
    if isinstance(walk, str):
        if walk not in _WALKS:
            raise ValueError(f"must be {' or '.join(_WALKS)} or a table")
    elif len(walk) < 2:
        raise ValueError("a walk table needs two rows at least")
    else:
        _check_table(walk)
    return walk


def _check_table(table: tuple[tuple[float, float], ...]) -> None:
    try:
        WalkCurve.from_table(*zip(*table, strict=True))
    except EchoplanError as error:
        raise ValueError(str(error)) from None


class EstimateSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of all stages of the estimator."""

    poses: PoseMode = Field(default=PoseMode.AUTO, description="trust, correct, or correct if the pings disagree")
    stations: StationSettings = Field(default_factory=StationSettings)
    window: WindowSettings = Field(default_factory=WindowSettings)
    arcs: ArcSettings = Field(default_factory=ArcSettings)
    search: SearchSettings = Field(default_factory=SearchSettings)
    optimiser: OptimiserSettings = Field(default_factory=OptimiserSettings)
    pose_errors: PoseSettings = Field(default_factory=PoseSettings)
    drift: OdometryNoiseSettings = Field(default_factory=OdometryNoiseSettings)
    certainty: ObservabilitySettings = Field(default_factory=ObservabilitySettings)
    squareness: ManhattanSettings = Field(default_factory=ManhattanSettings)
    copies: DuplicateSettings = Field(default_factory=DuplicateSettings)
    localisation: LocalisationSettings = Field(default_factory=LocalisationSettings)
    segments: SegmentSettings = Field(default_factory=SegmentSettings)
    vertices: CornerSettings = Field(default_factory=CornerSettings)
    survey: MapSettings = Field(default_factory=MapSettings)
    walk: Annotated[str | tuple[tuple[float, float], ...], AfterValidator(_falls)] = Field(
        default="physical",
        description="range walk: that of the burst, one fitted to the recording where poses do not drift, or a table "
        "of how far [m] readings of a signal excess [dB] are too far",
    )
    first_noise: float = Field(default=0.008, gt=0.0, description="of readings before anything is known [m]")
    least_noise: float = Field(default=0.0015, gt=0.0, description="of the best sensors [m]")
    greatest_noise: float = Field(default=0.05, gt=0.0, description="of readings that still make a map [m]")
    torn: float = Field(default=0.25, gt=0.0, le=1.0, description="share of walls that are there twice if poses drift")
    # Pose errors of a quarter of the noise give an intraclass correlation of 1 / (1 + 4^2).
    shared_error: float = Field(
        default=0.06, gt=0.0, le=1.0, description="of a station's readings of a wall, that makes poses doubtful"
    )
    by_hand: int = Field(default=24, ge=0, description="way-points that somebody sets by hand, at most; 0: nobody does")
    scale_step: float = Field(default=0.004, gt=0.0, description="of the range scale that calls for another look")
    min_inlier_ratio: float = Field(
        default=0.88, gt=0.0, le=1.0, description="share of echoes that exact poses explain"
    )
