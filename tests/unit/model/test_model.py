"""One battery for all values of the model: frozen they are called, and frozen they are."""

from dataclasses import FrozenInstanceError, fields
from typing import Any

import numpy as np
import pytest

from echoplan.model import (
    Corner,
    Cylinder,
    FeatureMap,
    Opening,
    Pillar,
    Pings,
    Polyline,
    Rig,
    Route,
    Sensor,
    Sweep,
    Truth,
    UnobservedStretch,
    Wall,
)

SENSOR = Sensor(sensor_id=0, half_aperture=0.6, min_range=0.03, max_range=3.0, resolution=0.005)
CASES: list[tuple[Any, dict[str, Any]]] = [
    (
        Wall,
        {
            "normal_angle": 0.0,
            "offset": 1.0,
            "endpoints_xy": np.eye(2),
            "covariance": np.eye(2),
            "endpoint_sigmas": np.ones(2),
            "inferred": np.ones(2),
        },
    ),
    (Opening, {"endpoints_xy": np.eye(2), "width_sigma": 0.0, "walls": ()}),
    (UnobservedStretch, {"endpoints_xy": np.eye(2), "walls": ()}),
    (Corner, {"position_xy": np.ones(2), "kind": "concave", "covariance": np.eye(2)}),
    (Cylinder, {"center_xy": np.ones(2), "radius": 0.1, "covariance": np.eye(3)}),
    (
        FeatureMap,
        {
            "method": "rcd",
            "sweeps": np.arange(2),
            "poses": np.ones((2, 3)),
            "pose_covariances": np.tile(np.eye(3), (2, 1, 1)),
        },
    ),
    (Rig, {"name": "one", "sensors": (SENSOR,), "base_from_turret": np.ones(3)}),
    (
        Sweep,
        {
            "index": 0,
            "stamps_ns": np.arange(2),
            "sensor_ids": np.zeros(2, dtype=int),
            "servo_angles": np.zeros(2),
            "ranges": np.ones(2),
            "map_from_base": np.zeros((2, 3)),
        },
    ),
    (
        Pings,
        {
            "origins_xy": np.zeros((2, 2)),
            "hubs_xy": np.zeros((2, 2)),
            "bearings": np.zeros(2),
            "ranges": np.ones(2),
            "sensors": np.zeros(2, dtype=int),
        },
    ),
    (Polyline, {"points_xy": np.eye(2)}),
    (Pillar, {"center_xy": np.ones(2), "radius": 0.1}),
    (Route, {"map_from_base": np.ones((2, 3)), "stamps_ns": np.arange(2)}),
    (
        Truth,
        {
            "walls_xy": np.arange(4.0).reshape(1, 2, 2),
            "walls_detected_by": np.arange(1),
            "cylinders": np.ones((1, 3)),
            "cylinders_detected_by": np.arange(1),
            "poses": np.ones((2, 3)),
            "given": np.ones((2, 3)),
        },
    ),
]


@pytest.mark.parametrize(("kind", "given"), CASES, ids=lambda case: getattr(case, "__name__", ""))
def test_no_field_of_a_value_can_be_set(kind: Any, given: dict[str, Any]) -> None:
    value = kind(**given)
    for field in fields(value):
        with pytest.raises(FrozenInstanceError):
            setattr(value, field.name, None)


@pytest.mark.parametrize(("kind", "given"), CASES, ids=lambda case: getattr(case, "__name__", ""))
def test_no_array_of_a_value_can_be_written_or_changed_through_what_it_was_made_from(
    kind: Any, given: dict[str, Any]
) -> None:
    value = kind(**given)
    arrays = [field.name for field in fields(value) if isinstance(getattr(value, field.name), np.ndarray)]
    assert arrays
    for name in arrays:
        array = getattr(value, name)
        assert not np.shares_memory(array, given[name])
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
