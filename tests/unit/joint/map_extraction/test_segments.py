"""Segments of wall lines: stations at x = 0 before the line x = 1, with other walls beside."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.track_history import LineEvidence
from echoplan.joint.map_extraction.endpoint_views import OFFSETS
from echoplan.joint.map_extraction.segment import CELL, Segment
from echoplan.joint.map_extraction.segments import SegmentSettings, find_segments
from echoplan.joint.search.corner_echoes import CornerEcho, Echoes
from helpers.expectations import NOISE, corner, cylinder, feature, listening, wall
from helpers.outlines import Stretch, detecting, remembered

EAST = wall(0.0, 1.0)
LONG = (EAST, -3.0, 3.0)
SILENT = Echoes()
NOWHERE = np.zeros((0, 2))


def row(spacing: float = 0.15, x: float = 0.0) -> list[tuple[float, float]]:
    """Return stations beside a line."""
    return [(x, float(y)) for y in np.arange(-1.5, 1.501, spacing)]


def segments_of(
    known: Sequence[Hypothesis], *, owner: int = 0, path_xy: FloatArray = NOWHERE, echoes: Echoes = SILENT
) -> list[Segment]:
    """Return the segments of one of the walls."""
    segments = find_segments(known, echoes, path_xy, SegmentSettings())
    return [each for each in segments if each.owner == owner]


def across(place: float) -> FloatArray:
    """Return a path that crosses all walls parallel to y."""
    return np.array([[0.0, place], [3.0, place]])


def missed_by(count: int, spacing: float) -> list[Hypothesis]:
    """Return the landmark x = 1, which a number of stations near y = 0 do not detect."""
    places = row(spacing)
    measurements = detecting(listening(places), [LONG])
    missing = np.argsort(np.abs(np.array(places)[:, 1]))[:count]
    silent = np.isin(measurements.stations, missing)
    return remembered(measurements._replace(readings=np.where(silent, np.inf, measurements.readings)), [EAST])


def test_a_wall_detected_by_all_stations_is_one_segment() -> None:
    (east,) = segments_of(remembered(detecting(listening(row()), [LONG]), [EAST]))
    assert (east.low, east.high) == pytest.approx((-1.5, 1.5), abs=0.04)
    assert east.ends == (None, None)


@pytest.mark.parametrize(
    ("low", "high", "spacing"),
    [(-0.4, 0.4, 0.15), (-0.33, 0.47, 0.15), (-0.4, 0.4, 0.1), (-0.25, 0.35, 0.2), (-0.45, 0.45, 0.3)],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_the_intervals_of_both_ends_contain_the_true_ends_of_a_gap(
    low: float, high: float, spacing: float, seed: int
) -> None:
    places = row(spacing)
    stretches: list[Stretch] = [(EAST, -3.0, low), (EAST, high, 3.0)]
    measurements = detecting(listening(places), stretches, noise=NOISE, rng=np.random.default_rng(seed))
    before, after = segments_of(remembered(measurements, [EAST]))
    feet = np.array(places)[:, 1]
    for end, place, drawn in ((before.ends[1], low, before.high), (after.ends[0], high, after.low)):
        assert end is not None
        # To a tenth of a cell: the likelihood is constant within one.
        assert end.interval[0] - 0.1 * CELL < place < end.interval[2] + 0.1 * CELL
        # The last station that detects the wall and the first that does not are at most that far away.
        assert abs(drawn - place) < spacing
        assert feet[feet < place].max() - 0.2 < drawn < feet[feet > place].min() + 0.2
    assert before.ends[0] is None
    assert after.ends[1] is None


def test_a_gap_that_many_stations_missed_is_free() -> None:
    before, after = segments_of(missed_by(10, 0.1))
    assert before.is_free(before.high, after.low)


@pytest.mark.parametrize("spacing", [0.3, 0.5])
def test_two_non_detecting_stations_open_a_wall_and_one_does_not(spacing: float) -> None:
    assert len(segments_of(missed_by(1, spacing))) == 1
    assert len(segments_of(missed_by(2, spacing))) == 2


@pytest.mark.parametrize("spacing", [0.2, 0.3, 0.5])
def test_a_short_wall_of_one_station_is_drawn(spacing: float) -> None:
    (stub,) = segments_of(remembered(detecting(listening(row(spacing)), [(EAST, -0.12, 0.12)]), [EAST]))
    middle = float(min(np.abs(row(spacing))[:, 1]))
    assert stub.low - 0.05 < middle < stub.high + 0.05
    assert stub.high - stub.low < 2 * spacing


def test_close_stations_open_a_wall_only_in_greater_number() -> None:
    # With neighbours 15 cm away, an opening would be very narrow.
    assert len(segments_of(missed_by(2, 0.15))) == 1
    assert len(segments_of(missed_by(6, 0.15))) == 2


def test_stations_that_would_also_detect_the_ends_of_a_gap_open_no_wall() -> None:
    (east,) = remembered(detecting(listening(row(0.5)), [LONG]), [EAST])
    # From far away or with a wide cone, a station detects a wall from a little past its end. Facing a narrow gap it
    # would detect the nearer end, not both.
    many = LineEvidence(np.full(8, 0.25), np.array([[0.0, 0.25]] * 8), np.zeros((8, 2, len(OFFSETS))))
    many.log_ratios[:, :, OFFSETS < 0.1] = 20.0
    history = replace(east.history, line=east.history.line.joined(many))
    assert len(segments_of([replace(east, history=history)])) == 1


def test_the_path_of_the_robot_opens_a_wall() -> None:
    known = remembered(detecting(listening(row()), [LONG]), [EAST])
    before, after = segments_of(known, path_xy=across(0.04))
    assert -0.15 < before.high < 0.04 < after.low < 0.2
    assert before.is_free(before.high, after.low)


@pytest.mark.parametrize("count", [15, 100])
def test_the_path_of_the_robot_outweighs_any_number_of_detections(count: int) -> None:
    many = [*row(), *[(0.0, 0.0)] * count, *[(0.0, 0.06)] * count]
    known = remembered(detecting(listening(many), [LONG]), [EAST])
    before, after = segments_of(known, path_xy=across(0.03))
    assert -0.15 < before.high < 0.03 < after.low < 0.2


@pytest.mark.parametrize(("recording", "parts"), [(0, 2), (1, 2), (2, 1)])
def test_a_wall_may_stand_where_the_robot_drove_in_recordings_before_it(recording: int, parts: int) -> None:
    gap = np.full((1, 2), np.nan)
    path_xy = np.vstack([across(10.0), gap, across(0.04), gap, across(20.0)])
    (east,) = remembered(detecting(listening(row()), [LONG]), [EAST])
    later = replace(east, history=replace(east.history, recording=recording))
    assert len(segments_of([later], path_xy=path_xy)) == parts


@pytest.mark.parametrize(("crossings", "parts"), [((), 1), ((0.07,), 1), ((0.04, 0.06, 0.07, 0.09), 2)])
def test_repeated_crossings_of_sound_open_a_wall(crossings: tuple[float, ...], parts: int) -> None:
    (east,) = remembered(detecting(listening(row()), [LONG]), [EAST])
    crossed = replace(east, history=replace(east.history, crossings=np.array(crossings)))
    assert len(segments_of([crossed])) == parts


def test_a_station_occluded_by_another_segment_does_not_count() -> None:
    # Too far before the line to be an object against it, so the wall is not split behind it.
    far, front = wall(0.0, 2.5), wall(0.0, 1.0)
    stations = [*row(), *((0.5, y) for y in np.linspace(-0.4, 0.4, 7).tolist())]
    measurements = detecting(listening(stations), [(far, -3.0, 3.0), (front, -0.4, 0.4)])
    behind = np.isin(measurements.stations, [8, 9, 10, 11, 12])
    known = remembered(measurements._replace(readings=np.where(behind, np.inf, measurements.readings)), [far, front])
    assert len(segments_of(known[:1])) == 2
    assert len(segments_of(known)) == 1


@pytest.mark.parametrize(("front", "parts"), [(False, 2), (True, 1)], ids=["alone", "front"])
def test_non_detections_behind_the_front_of_a_body_open_no_wall(*, front: bool, parts: int) -> None:
    # The front of a body from y = -0.25 on, of unknown depth.
    south = wall(np.pi / 2, -0.25)
    stations = [*row(0.1), (0.4, -0.9), (0.6, -0.9)]
    measurements = detecting(listening(stations), [LONG, (south, -0.8, -0.3)])
    missing = [number for number, (x, y) in enumerate(stations) if x == 0.0 and abs(y) < 0.24]
    silent = np.isin(measurements.stations, missing)
    known = remembered(measurements._replace(readings=np.where(silent, np.inf, measurements.readings)), [EAST, south])
    assert len(segments_of(known if front else known[:1])) == parts


@pytest.mark.parametrize(("ratio", "parts"), [(1.5, 1), (40.0, 2)])
def test_a_stretch_without_a_certain_cell_is_not_drawn(ratio: float, parts: int) -> None:
    (east,) = remembered(detecting(listening(row()), [LONG]), [EAST])
    far = LineEvidence(np.array([3.0, 3.1]), np.array([[0.0, 3.0], [0.0, 3.1]]), np.full((2, 2, len(OFFSETS)), 0.0))
    far.log_ratios[:, :, OFFSETS <= 0.0] = ratio
    crossings = np.full(2, 2.2)
    history = replace(east.history, line=east.history.line.joined(far), crossings=crossings)
    assert len(segments_of([replace(east, history=history)])) == parts


@pytest.mark.parametrize(("back", "spans_of_the_wall"), [(False, 2), (True, 1)], ids=["front alone", "front and back"])
def test_behind_an_object_a_wall_continues_only_if_its_back_was_detected(*, back: bool, spans_of_the_wall: int) -> None:
    far, front, behind = wall(0.0, 1.9), wall(0.0, 1.0), wall(np.pi, -1.2)
    stations = [*row(0.1), (1.55, -0.65), (1.55, 0.65)]
    stretches: list[Stretch] = [(far, -3.0, 3.0), (front, -0.3, 0.3)]
    reflectors = [far, front]
    if back:
        stations += [(1.55, -0.2), (1.55, 0.2)]
        stretches, reflectors = [*stretches, (behind, -0.3, 0.3)], [*reflectors, behind]
    known = remembered(detecting(listening(stations), stretches), reflectors)
    assert len(segments_of(known)) == spans_of_the_wall


def beside_a_door(*, north: bool) -> list[Hypothesis]:
    """Return the wall x = 2 up to a door, beyond which there is no station, and the wall y = 1.5, which ends it."""
    far, other = wall(0.0, 2.0), wall(np.pi / 2, 1.5)
    stations = [(0.9, float(y)) for y in np.arange(-1.5, -0.01, 0.15)]
    stations += [(float(x), 0.7) for x in np.arange(-1.0, 1.6, 0.15)]
    stretches: list[Stretch] = [(far, -3.0, 0.2), (other, -2.0, 3.0)]
    known = remembered(detecting(listening(stations), stretches), [far, other])
    return known if north else known[:1]


def test_a_corner_of_two_known_walls_supports_a_short_segment() -> None:
    echoes = Echoes(pairs={(0, 1): CornerEcho(pings=8, stations=2, detections=30.0, gain=5.0)})
    assert len(segments_of(beside_a_door(north=True), path_xy=across(0.7))) == 1
    before, stub = segments_of(beside_a_door(north=True), path_xy=across(0.7), echoes=echoes)
    assert before.high == pytest.approx(0.2, abs=0.1)
    assert stub.low > 0.7
    assert stub.high == pytest.approx(1.5, abs=0.03)


def test_a_weakly_detected_corner_supports_no_segment() -> None:
    weak = Echoes(pairs={(0, 1): CornerEcho(pings=8, stations=1, detections=30.0, gain=-29.0)})
    assert len(segments_of(beside_a_door(north=True), path_xy=across(0.7), echoes=weak)) == 1


def test_a_lone_corner_supports_no_segment() -> None:
    echoes = Echoes(corners_xy=np.array([[2.0, 1.5]]))
    assert len(segments_of(beside_a_door(north=False), path_xy=across(0.7), echoes=echoes)) == 1


def drawn_beside(other: Stretch, stations: Sequence[tuple[float, float]] = ((-0.3, 0.6), (-0.3, 0.8))) -> list[int]:
    """Return the owners of the segments of the wall x = 1 and of another wall that a few other stations detect."""
    (east,) = remembered(detecting(listening(row()), [LONG]), [EAST])
    (copy,) = remembered(detecting(listening(stations), [other]), [other[0]])
    return [each.owner for each in find_segments([copy, east], SILENT, NOWHERE, SegmentSettings())]


@pytest.mark.parametrize(
    "other", [(wall(0.0, 1.02), 0.3, 1.1), (wall(np.radians(2.0), 1.0), 0.3, 1.1)], ids=["behind it", "askew"]
)
def test_of_two_overlapping_walls_the_one_with_more_pings_is_drawn(other: Stretch) -> None:
    assert drawn_beside(other) == [1]


@pytest.mark.parametrize(
    ("other", "stations"),
    [
        ((wall(0.0, 0.9), 0.3, 1.1), ((-0.3, 0.6), (-0.3, 0.8))),
        ((wall(0.0, 1.01), 1.9, 3.0), ((0.0, 2.2), (0.0, 2.5))),
        ((wall(np.pi, -1.02), -1.1, -0.3), ((1.7, 0.6), (1.7, 0.8))),
    ],
    ids=["before it", "farther on", "other face"],
)
def test_two_walls_apart_are_both_drawn(other: Stretch, stations: Sequence[tuple[float, float]]) -> None:
    assert set(drawn_beside(other, stations)) == {0, 1}


def test_only_walls_with_line_evidence_have_segments() -> None:
    known = [feature(corner(1.0, 1.0)), feature(cylinder(0.0, 1.0, 0.1)), feature(EAST)]
    assert find_segments(known, SILENT, NOWHERE, SegmentSettings()) == []
    assert find_segments([], SILENT, NOWHERE, SegmentSettings()) == []


def test_segments_are_in_the_order_of_the_landmarks() -> None:
    measurements = detecting(listening([(0.0, 0.0), (0.2, 0.1), (-0.2, -0.1)]), [LONG, (wall(np.pi, 1.1), -2.0, 2.0)])
    known = [feature(cylinder(5.0, 5.0, 0.1)), *remembered(measurements, [wall(np.pi, 1.1), EAST])]
    segments = find_segments(known, SILENT, NOWHERE, SegmentSettings())
    assert [each.owner for each in segments] == [1, 2]
    assert all(each.pings > 20 for each in segments)
    assert (segments[1].low, segments[1].high) == pytest.approx((-0.15, 0.15), abs=0.05)


def test_a_distant_crossing_of_the_path_adds_no_cells() -> None:
    known = remembered(detecting(listening(row()), [LONG]), [EAST])
    (here,), (far,) = segments_of(known), segments_of(known, path_xy=across(1000.0))
    assert len(far.chances) == len(here.chances)
