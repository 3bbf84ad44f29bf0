"""Wall lines of which stations detected a part, for tests of outlines."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, echo_geometry, excess_of, shape_of, walk_of
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, is_blocked
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.track_history import TrackHistory
from echoplan.joint.map_extraction.corners import CornerSettings, find_vertices
from echoplan.joint.map_extraction.endpoint_views import line_evidence
from echoplan.joint.map_extraction.map_builder import MapBuilder, MapSettings
from echoplan.joint.map_extraction.segment import CELL, End, Segment
from echoplan.joint.map_extraction.surroundings import points_on
from echoplan.joint.optimisation.edge_diffraction import diffracted, edges_of
from echoplan.joint.optimisation.optimiser import Features, OptimiserSettings, Priors, optimise
from echoplan.joint.optimisation.values import Values
from echoplan.joint.search.corner_echoes import Echoes
from echoplan.joint.search.ray_paths import trace_paths
from echoplan.model import ClassProbabilities
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import NOISE, REACH, ROOM, SONAR, feature, likelihood, listening, pings_of, rescored, wall

SILENT = Echoes()
SURE = ClassProbabilities(wall=0.8, corner=0.15, cylinder=0.05)
STEP = np.radians(3.0)
# A wall as four numbers, and between which places along its line it stands.
Stretch = tuple[FloatArray, float, float]


def segment(
    normal_angle: float,
    offset: float,
    ends: tuple[float, float],
    *,
    owner: int = 0,
    free: float | None = None,
    chance: float = 0.0,
    known: tuple[End | None, End | None] = (None, None),
) -> Segment:
    """A segment by its line and its ends along it; at one place there may be no wall, with a chance that there is."""
    start, chances = -3.0, np.full(300, 0.9)
    if free is not None:
        chances[int((free - start) / CELL)] = chance
    return Segment(
        owner=owner,
        wall=feature(wall(normal_angle, offset)),
        low=ends[0],
        high=ends[1],
        ends=known,
        pings=50,
        start=start,
        chances=chances,
    )


def detecting(
    measurements: Measurements,
    stretches: Sequence[Stretch],
    *,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> Measurements:
    """Give each ping the nearest detectable echo of walls with ends, of those that no other wall blocks."""
    sonar, nearest = SONAR.tabulated(), measurements.readings
    origins = np.column_stack([measurements.x, measurements.y])
    ends = [points_on(each[1:3], np.array([low, high])) for each, low, high in stretches]
    for number, (reflector, low, high) in enumerate(stretches):
        feet = origins @ directions(reflector[1] + np.pi / 2)
        others = np.array([each for other, each in enumerate(ends) if other != number]).reshape(-1, 2, 2)
        targets = points_on(reflector[1:3], feet.clip(low, high))
        blocked = is_blocked(origins, targets, segments_xy=others, discs=np.zeros((0, 3)))
        shape, readings = shape_of(reflector), np.full(len(nearest), np.inf)
        for ping in np.flatnonzero(~blocked):
            place = measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping]
            geometry = echo_geometry(shape, place)
            if geometry[0] <= measurements.min_range:
                continue
            geometry = diffracted(geometry, low - feet[ping], feet[ping] - high, sonar.wavelength)
            excess = excess_of(sonar, geometry)
            if excess > 0.0:
                readings[ping] = (geometry[0] + walk_of(sonar, excess)) / sonar.scale
        nearest = np.minimum(nearest, readings)
    jitter = rng.normal(0.0, noise, len(nearest)) if rng is not None else 0.0
    return measurements._replace(readings=np.where(nearest < measurements.max_range, nearest + jitter, np.inf))


def remembered(measurements: Measurements, reflectors: Sequence[FloatArray]) -> list[Hypothesis]:
    """Return walls whose track histories hold the line evidence of all stations."""
    estimate, count = likelihood(measurements), len(measurements.centers)
    found = rescored(estimate, reflectors)
    paths, left_out = trace_paths(estimate, found, step=STEP), estimate.log_densities_without(found)
    return [
        replace(
            each,
            history=TrackHistory(
                number=number,
                pings=int((paths.owners == number).sum()),
                feet=paths.feet(number, each.line),
                crossings=paths.crossings(number, each.line),
                line=line_evidence(estimate, each, count, log_densities),
            ),
        )
        for number, (each, log_densities) in enumerate(zip(found, left_out, strict=True))
    ]


def past_of(known: Hypothesis, number: int, pings: int) -> TrackHistory:
    """Return a track history; stations with an LLR above 5 nats support it."""
    return TrackHistory(
        number=number, supporting=int((known.llr_by_station > 5.0).sum()), pings=pings, probabilities=SURE
    )


def survey(
    *others: Hypothesis,
    walls: Sequence[FloatArray] | FloatArray = ROOM,
    detected_to: float = 1.2,
    joined: bool = True,
    echoes: Echoes = SILENT,
    pieces: Mapping[int, Sequence[Segment]] = MappingProxyType({}),
) -> MapBuilder:
    """The map of a room of 4 x 3 m that was detected but for the corners; some walls may be in pieces."""
    known = [*(feature(each, llr_by_station=[9.0, 6.0, 4.0, -1.0]) for each in walls), *others]
    reflectors = np.array([each.reflector for each in known]).reshape(-1, 4)
    extents = np.tile([-REACH, REACH], (len(known), 1))
    features = Features(
        reflectors=reflectors,
        extents=extents,
        attenuations=np.zeros((len(known), 4)),
        bias_variances=np.zeros((len(known), 4)),
        ends=edges_of(reflectors, extents),
    )
    truth = [*ROOM, *(each for each in reflectors if each[0] == Kind.CYLINDER)]
    priors = Priors(noise=NOISE, offset_sigma=0.0015, walk_gain=SONAR.walk_gain, has_servo=False, scale_sigma=0.03)
    start = Values(features=features, model=SONAR)
    solution = optimise(pings_of(listening(), truth), start, priors, OptimiserSettings())
    known = [
        replace(each, history=past_of(each, number, int((solution.owners == number).sum())))
        for number, each in enumerate(known)
    ]
    segments = [
        replace(piece, wall=each, pings=40 + number)
        for number, each in enumerate(known)
        if each.is_wall
        for piece in pieces.get(
            number, [segment(each.line[0], each.line[1], (-detected_to, detected_to), owner=number)]
        )
    ]
    return MapBuilder(
        features=known,
        solution=solution,
        segments=segments,
        vertices=find_vertices(segments, echoes, CornerSettings()) if joined else [],
        manhattan_prior=None,
        settings=MapSettings(),
    )
