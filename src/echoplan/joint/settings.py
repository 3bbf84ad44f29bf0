"""Settings of all stages of the estimator."""

from enum import StrEnum
from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field

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
from echoplan.settings import Settings

__all__ = ["EstimateSettings", "PoseMode", "WindowSettings"]


# Names of range walks that need no table.
_WALKS = ("physical", "fitted")


class PoseMode(StrEnum):
    """How recorded poses are used."""

    TRUST = "trust"
    CORRECT = "correct"
    AUTO = "auto"


class WindowSettings(Settings):
    """Number of stations that are optimised together."""

    former_keys: ClassVar = {"step": "stride"}

    stations: int = Field(
        default=24, ge=3, description="Number of stations that stay in the window when others are marginalised."
    )
    stride: int = Field(default=12, ge=1, description="Number of stations that are marginalised together.")


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


class EstimateSettings(Settings):
    """Settings of all stages of the estimator."""

    former_keys: ClassVar = {
        "agreement": "min_inlier_ratio",
        "adjustment": "optimiser",
        "drift": "odometry_noise",
        "certainty": "observability",
        "squareness": "manhattan",
        "copies": "duplicates",
        "vertices": "corners",
        "survey": "map",
        "first_noise": "initial_sigma",
        "least_noise": "min_sigma",
        "greatest_noise": "max_sigma",
        "torn": "max_duplicate_fraction",
        "shared_error": "max_icc",
        "by_hand": "max_waypoints",
    }

    poses: PoseMode = Field(
        default=PoseMode.AUTO,
        description="How recorded poses are used: trust, correct, or auto, which corrects them if the pings disagree.",
    )
    stations: StationSettings = Field(default_factory=StationSettings)
    window: WindowSettings = Field(default_factory=WindowSettings)
    arcs: ClassVar[ArcSettings] = ArcSettings()
    search: SearchSettings = Field(default_factory=SearchSettings)
    optimiser: OptimiserSettings = Field(default_factory=OptimiserSettings)
    pose_errors: PoseSettings = Field(default_factory=PoseSettings)
    odometry_noise: ClassVar[OdometryNoiseSettings] = OdometryNoiseSettings()
    observability: ClassVar[ObservabilitySettings] = ObservabilitySettings()
    manhattan: ManhattanSettings = Field(default_factory=ManhattanSettings)
    duplicates: ClassVar[DuplicateSettings] = DuplicateSettings()
    localisation: ClassVar[LocalisationSettings] = LocalisationSettings()
    segments: SegmentSettings = Field(default_factory=SegmentSettings)
    corners: CornerSettings = Field(default_factory=CornerSettings)
    map: MapSettings = Field(default_factory=MapSettings)
    walk: Annotated[str | tuple[tuple[float, float], ...], AfterValidator(_falls)] = Field(
        default="physical",
        description="Range walk (time walk): physical for that of the burst, fitted for one fitted to the "
        "recording where poses do not drift, or a table of the errors [m] of readings over their "
        "signal excess [dB].",
    )
    initial_sigma: float = Field(
        default=0.008, gt=0.0, description="Standard deviation of readings before the first optimisation [m]."
    )
    min_sigma: float = Field(
        default=0.0015, gt=0.0, description="Smallest standard deviation of readings, that of the best sensors [m]."
    )
    max_sigma: float = Field(
        default=0.05, gt=0.0, description="Largest standard deviation of readings that can still be mapped [m]."
    )
    # Largest share of walls that are drawn twice before poses count as drifting.
    max_duplicate_fraction: ClassVar[float] = 0.25
    # Largest intraclass correlation of the readings of a wall from one station before poses count as doubtful: that
    # of pose errors of a quarter of the noise, 1 / (1 + 4^2).
    max_icc: ClassVar[float] = 0.06
    max_waypoints: int = Field(
        default=24,
        ge=0,
        description="Largest number of stations whose poses may be waypoints set by hand; 0 for never.",
    )
    # Change of the range scale above which landmarks are searched again.
    scale_step: ClassVar[float] = 0.004
    min_inlier_ratio: float = Field(
        default=0.88, gt=0.0, le=1.0, description="Smallest share of echoes that the map explains if poses are exact."
    )
