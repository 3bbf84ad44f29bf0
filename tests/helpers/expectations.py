"""Readings as the model of a sonar predicts them, which a method that knows the model must explain."""

from collections.abc import Sequence

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel, Kind, predict_echo, shape_of
from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import ANYWHERE, Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES, PingScores, score_pings
from echoplan.joint.search.scan_matching import LandmarkMap
from echoplan.preprocessing.measurements import Measurements
from helpers.simulated_worlds import PAPER

SONAR = EchoModel.of(PAPER)
REACH = 4.0
NOISE = 0.003
# Walls of a room of 4 x 3 m about the origin, as a robot inside detects them: east, north, west, south.
ROOM = np.array(
    [
        [Kind.WALL, 0.0, 2.0, 0.0],
        [Kind.WALL, np.pi / 2, 1.5, 0.0],
        [Kind.WALL, np.pi, 2.0, 0.0],
        [Kind.WALL, -np.pi / 2, 1.5, 0.0],
    ]
)
STATIONS = ((-0.9, 0.1), (-0.2, -0.5), (0.5, 0.3), (1.1, -0.3))


def wall(normal_angle: float, offset: float) -> FloatArray:
    """A wall as four numbers."""
    return np.array([Kind.WALL, normal_angle, offset, 0.0])


def cylinder(x: float, y: float, radius: float) -> FloatArray:
    """A cylinder as four numbers."""
    return np.array([Kind.CYLINDER, x, y, radius])


def corner(x: float, y: float) -> FloatArray:
    """A concave corner as four numbers."""
    return np.array([Kind.CORNER, x, y, 0.0])


def edge(x: float, y: float) -> FloatArray:
    """A convex edge as four numbers."""
    return np.array([Kind.EDGE, x, y, 0.0])


def round_wall(x: float, y: float, radius: float) -> FloatArray:
    """The inside of a round wall as four numbers."""
    return np.array([Kind.ROUND, x, y, radius])


def listening(
    stations_xy: Sequence[tuple[float, float]] = STATIONS,
    *,
    step: float = np.radians(3.0),
    arm: float = 0.05,
    rates: Sequence[float] = (),
) -> Measurements:
    """Pings all around each station, of which none detected anything; the servo may turn in each."""
    bearings = np.arange(-np.pi, np.pi - 1e-9, step)
    count, hubs = len(stations_xy), np.repeat(np.array(stations_xy), len(bearings), axis=0)
    axes = np.tile(directions(bearings), (count, 1))
    places = hubs + arm * axes
    return Measurements(
        x=places[:, 0].copy(),
        y=places[:, 1].copy(),
        ux=axes[:, 0].copy(),
        uy=axes[:, 1].copy(),
        arms_x=arm * axes[:, 0],
        arms_y=arm * axes[:, 1],
        angles=np.tile(bearings, count),
        rates=np.repeat(np.array(rates or [0.0] * count), len(bearings)),
        readings=np.full(len(hubs), np.inf),
        stations=np.repeat(np.arange(count), len(bearings)),
        sensors=np.zeros(len(hubs), dtype=np.int64),
        crosstalk_sources=np.full((len(hubs), 1), -1),
        crosstalk_delays=np.zeros((len(hubs), 1)),
        weights=np.full(len(hubs), min(1.0, step / np.radians(4.0))),
        ways=np.zeros(len(hubs)),
        centers=np.array(stations_xy, dtype=np.float64),
        min_range=0.03,
        max_range=REACH,
    )


def expected(
    measurements: Measurements, reflector: FloatArray, sonar: EchoModel = SONAR
) -> tuple[FloatArray, FloatArray]:
    """Signal excess [dB] and reading [m] of a reflector that each ping would give, were it detected."""
    tables, shape = sonar.tabulated(), shape_of(reflector)
    rays = zip(measurements.x, measurements.y, measurements.ux, measurements.uy, strict=True)
    depths, excesses, readings = np.array([predict_echo(tables, shape, ray) for ray in rays]).T
    return np.where(depths > measurements.min_range, excesses, -np.inf), readings / tables.scale


def pings_of(
    measurements: Measurements,
    reflectors: Sequence[FloatArray] | FloatArray,
    *,
    sonar: EchoModel = SONAR,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> Measurements:
    """Give each ping the nearest echo that is loud enough."""
    nearest = measurements.readings
    for reflector in reflectors:
        excesses, readings = expected(measurements, reflector, sonar)
        nearest = np.minimum(nearest, np.where(excesses > 0.0, readings, np.inf))
    jitter = rng.normal(0.0, noise, len(nearest)) if rng is not None else 0.0
    return measurements._replace(readings=np.where(nearest < measurements.max_range, nearest + jitter, np.inf))


def returning(measurements: Measurements, vertex_xy: tuple[float, float], opening: float) -> Measurements:
    """Give each ping within 25 degrees of a corner what it sends back: nearer, if it is acute, by the sine of that."""
    x, y = vertex_xy[0] - measurements.x, vertex_xy[1] - measurements.y
    ahead = x * measurements.ux + y * measurements.uy > np.hypot(x, y) * np.cos(np.radians(25.0))
    away = np.hypot(x, y) * np.sin(np.radians(min(opening, 90.0)))
    return measurements._replace(readings=np.where(ahead, away, measurements.readings))


def evidence_for(measurements: Measurements, reflector: FloatArray) -> PingScores:
    """Return the ping scores of a reflector at the usual noise."""
    return score_pings(measurements, SONAR.tabulated(), reflector, NOISE)


def likelihood(measurements: Measurements, *, sonar: EchoModel = SONAR, noise: float = NOISE) -> PingLikelihood:
    """The likelihood of pings that nothing explains so far."""
    return PingLikelihood(measurements, sonar.tabulated(), noise)


def rescored(estimate: PingLikelihood, reflectors: Sequence[FloatArray] | FloatArray) -> list[Hypothesis]:
    """Reflectors with the evidence for each of them alone."""
    bare = np.full(len(estimate.measurements.readings), estimate.floor)
    return estimate.score_all([estimate.score(each) for each in reflectors], bare, [])


def feature(
    reflector: FloatArray, *, extent: tuple[float, float] = (0.0, 0.0), llr_by_station: Sequence[float] = (20.0,)
) -> Hypothesis:
    """A hypothesis that is taken for granted: there is no evidence for it."""
    return Hypothesis(
        reflector=reflector,
        ping_scores=NO_PING_SCORES,
        llr_by_station=np.array(llr_by_station),
        llr=float(sum(llr_by_station)),
        extent=extent,
    )


def landmark_map(reflectors: FloatArray) -> LandmarkMap:
    """Long walls and other landmarks, all equally sure and detected from anywhere."""
    count = len(reflectors)
    return LandmarkMap(reflectors, np.ones(count), np.tile([-REACH, REACH], (count, 1)), np.tile(ANYWHERE, (count, 1)))
