from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echoplan.arrays import FloatArray, IntArray
from echoplan.joint.map_extraction.markov_chain import Chain, smoothed

COUNT, REACH = 8, 2
POTENTIALS = st.floats(-30.0, 30.0)


def enumerated(cells: FloatArray, near: FloatArray, ends: FloatArray, stay: FloatArray) -> Chain:
    """Return the marginals by summing over all 2^n states."""
    count = len(cells)
    states = np.array(list(product((0, 1), repeat=count)))
    before, after = states[:, :-1], states[:, 1:]
    # At each border: outside, inside, lower end, upper end.
    kinds = [(before + after == 0, stay[0]), (before * after == 1, stay[1]), (after > before, ends[0])]
    kinds.append((before > after, ends[1]))
    logs = states @ cells + sum((which * level).sum(axis=1) for which, level in kinds)
    logs += [by_the_nearest_end(state, near) for state in states]
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    return Chain(weights @ states, np.stack([weights @ (after > before), weights @ (before > after)]))


def by_the_nearest_end(state: IntArray, near: FloatArray) -> float:
    """Return the sum of what each cell outside of walls has for the nearest wall, the one before it if both are."""
    total, walls = 0.0, np.flatnonzero(state)
    for cell in np.flatnonzero(state == 0):
        past = cell - walls[walls < cell].max(initial=-len(state))
        until = walls[walls > cell].min(initial=2 * len(state)) - cell
        side, distance = (0, past) if past <= until else (1, until)
        total += near[cell, side, distance - 1] if distance <= near.shape[2] else 0.0
    return total


@pytest.mark.parametrize("reach", [1, 2, 3, 6])
@pytest.mark.parametrize("seed", range(5))
def test_marginals_equal_those_by_enumeration(seed: int, reach: int) -> None:
    rng = np.random.default_rng(seed)
    cells, ends, stay = rng.normal(0.0, 3.0, COUNT), *rng.normal(-1.0, 2.0, (2, 2, COUNT - 1))
    near = rng.normal(0.0, 3.0, (COUNT, 2, reach))
    found, truth = smoothed(cells, near, ends, stay), enumerated(cells, near, ends, stay)
    assert found.wall == pytest.approx(truth.wall, abs=1e-12)
    assert found.ends == pytest.approx(truth.ends, abs=1e-12)


@given(
    arrays(float, COUNT, elements=POTENTIALS),
    arrays(float, (COUNT, 2, REACH), elements=POTENTIALS),
    arrays(float, (2, COUNT - 1), elements=POTENTIALS),
    arrays(float, (2, COUNT - 1), elements=POTENTIALS),
)
def test_marginals_equal_those_by_enumeration_for_any_potentials(
    cells: FloatArray, near: FloatArray, ends: FloatArray, stay: FloatArray
) -> None:
    found, truth = smoothed(cells, near, ends, stay), enumerated(cells, near, ends, stay)
    assert found.wall == pytest.approx(truth.wall, abs=1e-9)
    assert found.ends == pytest.approx(truth.ends, abs=1e-9)
    # Lower minus upper ends equal the change of the wall probability between two cells.
    assert found.ends[0] - found.ends[1] == pytest.approx(np.diff(found.wall), abs=1e-9)


def test_contradictory_evidence_of_hundreds_of_stations_leaves_probabilities() -> None:
    cells = np.repeat([265.0, -150.0, -1e6, 265.0], 30)
    near, border = np.full((120, 2, REACH), -150.0), np.full((2, 119), np.log(0.0067))
    found = smoothed(cells, near, border, np.full((2, 119), np.log1p(-0.0067)))
    assert found.wall == pytest.approx(np.repeat([1.0, 0.0, 0.0, 1.0], 30), abs=1e-6)
    assert found.ends.sum(axis=1) == pytest.approx([1.0, 1.0])


def test_the_probability_of_a_single_cell_follows_from_its_ratio() -> None:
    found = smoothed(np.array([np.log(3.0)]), np.zeros((1, 2, REACH)), np.zeros((2, 0)), np.zeros((2, 0)))
    assert found.wall == pytest.approx([0.75])
    assert found.ends.shape == (2, 0)
