import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.search.acceptance import Belief, BeliefSettings
from echoplan.joint.search.multipath_walls import without_phantoms
from echoplan.joint.search.refinement import approach
from helpers.expectations import NOISE, SONAR, explanation, feature, hearing, judged, listening, returning, wall
from helpers.single_ping import PLAIN

# A passage, and a wall across its end far beyond, of which all but one station are too far to hear anything.
SIDES = (wall(np.pi / 2, 0.6), wall(-np.pi / 2, 0.6))
END = wall(0.0, 2.0)
STATIONS = ((-0.4, 0.1), (0.0, -0.1), (0.5, 0.0))


def left(*, span: float, volleys: bool = True, end: float = 2.0) -> list[float]:
    """Normal angles of the walls that stay if one station hears the end over so many degrees."""
    silent, rng, beyond = listening(STATIONS), np.random.default_rng(2), wall(0.0, end)
    sides, far = (hearing(silent, each, noise=NOISE, rng=rng).readings for each in (SIDES, [beyond]))
    heard = (silent.stations == 1) & (np.abs(silent.bearings) < np.radians(span / 2))
    soundings = silent._replace(readings=np.minimum(sides, np.where(heard, far, np.inf)))
    if volleys:
        soundings = soundings._replace(mates=np.arange(len(soundings.readings))[:, None] - 1)
    account = explanation(soundings)
    belief = Belief(soundings, half_aperture=0.61, settings=BeliefSettings())
    features = judged(account, [*SIDES, beyond])
    assert all(belief.holds(each, account.levels([])) for each in features)
    kept = without_phantoms(account, features, belief)
    return [round(float(each.line[0]), 3) for each in kept if each.kind is Kind.WALL]


BESIDES = [round(np.pi / 2, 3), -round(np.pi / 2, 3)]


def test_a_far_wall_that_one_station_does_not_hear_all_over_may_be_a_phantom() -> None:
    assert left(span=48.0) == BESIDES


def test_one_that_is_heard_all_over_stays() -> None:
    assert left(span=180.0) == [*BESIDES, 0.0]


def test_a_wall_no_farther_than_others_is_none() -> None:
    # Sound would not have had the time to meet two walls.
    assert left(span=66.0, end=0.8) == [*BESIDES, 0.0]


def test_where_sensors_fire_one_by_one_none_hears_what_another_sent() -> None:
    assert left(span=48.0, volleys=False) == [*BESIDES, 0.0]


def test_without_walls_about_it_nothing_is_a_phantom() -> None:
    soundings = listening(STATIONS)
    account = explanation(soundings._replace(mates=np.zeros((len(soundings.readings), 1), dtype=np.int64)))
    belief = Belief(soundings, half_aperture=0.61, settings=BeliefSettings())
    end = feature(END, gains=(0.0, 20.0, 0.0))
    assert without_phantoms(account, [], belief) == []
    assert without_phantoms(account, [end], belief) == [end]


@pytest.mark.parametrize(("known", "stays"), [(wall(np.pi / 2, 1.5), 0), (wall(np.pi / 2, 4.5), 1)])
def test_a_wall_stands_only_if_no_corner_of_a_known_one_explains_it_as_well(known: FloatArray, stays: int) -> None:
    soundings = returning(listening(((-0.4, -0.3), (0.3, -0.1), (3.0, -9.0))), (1.2, 1.5), 78.0)
    account = explanation(soundings, sonar=PLAIN)
    ahead, course = np.flatnonzero(np.isfinite(soundings.readings)), [(0.02, 0.2, 20), (0.003, 0.03, 20)]
    across = approach(soundings, PLAIN.tabulated(), wall(0.9, 1.85), ahead, course)
    strong, (seeming,) = feature(known, extent=(-0.8, 0.9), gains=(200.0, 200.0, 0.0)), judged(account, [across])
    belief = Belief(soundings, half_aperture=0.61, settings=BeliefSettings())
    assert belief.holds(seeming, account.levels([strong]))
    assert without_phantoms(account, [seeming, strong], belief) == [seeming, strong][1 - stays :]


def test_rays_read_an_edge_from_one_station_as_a_wall() -> None:
    soundings, seeing = listening(STATIONS), SONAR.seeing(0.26)
    belief = Belief(soundings, half_aperture=0.26, settings=BeliefSettings())
    lone, plain = feature(END, gains=(0.0, 40.0, 0.0)), feature(SIDES[0], gains=(20.0, 30.0, 20.0))
    assert without_phantoms(explanation(soundings, sonar=seeing), [lone, plain], belief) == [plain]
    assert without_phantoms(explanation(soundings), [lone, plain], belief) == [lone, plain]
