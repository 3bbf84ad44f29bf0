"""Any map that can be: strategies for tests of whatever reads, writes or draws maps."""

from typing import Any

import numpy as np
from hypothesis import strategies as st

from echoplan.model import (
    ClassProbabilities,
    Corner,
    CornerKind,
    Cylinder,
    FeatureMap,
    Opening,
    UnobservedStretch,
    Wall,
)

lengths = st.floats(-10.0, 10.0)
sizes = st.floats(1e-6, 10.0)
angles = st.floats(-12.0, 12.0)
counts = st.integers(0, 2**40)
names = st.text(min_size=1, max_size=20)
poses = st.tuples(lengths, lengths, angles)


def covariances(size: int) -> st.SearchStrategy[Any]:
    roots = st.lists(sizes, min_size=size * size, max_size=size * size).map(lambda r: np.reshape(r, (size, size)))
    return roots.map(lambda root: (root @ root.T + (root @ root.T).T) / 2.0)


@st.composite
def evidence(draw: st.DrawFn, size: int) -> dict[str, Any]:
    wall, corner = draw(st.tuples(st.floats(0.0, 0.5), st.floats(0.0, 0.5)))
    probabilities = ClassProbabilities(wall=wall, corner=corner, cylinder=1.0 - wall - corner)
    return {
        "covariance": draw(covariances(size)),
        "class_probabilities": probabilities,
        "pings": draw(counts),
        "stations": draw(counts),
    }


@st.composite
def walls(draw: st.DrawFn) -> Wall:
    start, length, angle = draw(st.tuples(st.tuples(lengths, lengths), st.floats(0.1, 9.0), angles))
    ends = np.array([start, np.add(start, [length, 0.0])])
    return Wall(
        normal_angle=angle,
        offset=draw(lengths),
        endpoints_xy=ends,
        endpoint_sigmas=np.array(draw(st.tuples(*2 * [sizes | st.just(np.nan)]))),
        inferred=np.array(draw(st.tuples(*2 * [sizes | st.just(0.0)]))),
        reflection_loss=draw(st.just(0.0) | st.floats(1.0, 30.0)),
        **draw(evidence(2)),
    )


@st.composite
def gaps(draw: st.DrawFn, walls: int) -> dict[str, Any]:
    """Ends of an opening or of a stretch, and the walls beside it."""
    start = draw(st.tuples(lengths, lengths))
    beside = draw(st.lists(st.integers(0, walls - 1), max_size=2)) if walls else []
    return {"endpoints_xy": np.array([start, np.add(start, [0.5, 0.0])]), "walls": tuple(beside)}


@st.composite
def corners(draw: st.DrawFn) -> Corner:
    position = np.array(draw(st.tuples(lengths, lengths)))
    return Corner(position_xy=position, kind=draw(st.sampled_from(CornerKind)), **draw(evidence(2)))


@st.composite
def cylinders(draw: st.DrawFn) -> Cylinder:
    center = np.array(draw(st.tuples(lengths, lengths)))
    return Cylinder(center_xy=center, radius=draw(sizes), **draw(evidence(3)))


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | lengths | names,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=3),
    max_leaves=6,
)


@st.composite
def maps(draw: st.DrawFn) -> FeatureMap:
    sweeps = draw(st.lists(counts, max_size=4))
    known = draw(st.sampled_from([sweeps, []]))
    faces = tuple(draw(st.lists(walls(), max_size=2)))
    beside = st.lists(gaps(len(faces)), max_size=2)
    return FeatureMap(
        method=draw(names),
        walls=faces,
        openings=tuple(Opening(width_sigma=draw(sizes), passed=draw(st.booleans()), **each) for each in draw(beside)),
        unobserved=tuple(UnobservedStretch(**each) for each in draw(beside)),
        corners=tuple(draw(st.lists(corners(), max_size=2))),
        cylinders=tuple(draw(st.lists(cylinders(), max_size=2))),
        sweeps=np.array(sweeps, dtype=np.int64),
        poses=np.array([draw(poses) for _ in sweeps]).reshape(-1, 3),
        pose_covariances=np.array([draw(covariances(3)) for _ in known]).reshape(-1, 3, 3),
        frame=draw(st.sampled_from(["map", "odom"])),
        parameters=draw(st.dictionaries(names, json_values, max_size=3)),
    )
