"""The marginal prior as plain arrays, as a file of a map holds it, so that another recording can go on from it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, checked_floats
from echoplan.errors import InvalidValueError
from echoplan.joint.landmarks import PARAMETERS
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES
from echoplan.joint.likelihood.track_history import NO_HISTORY, LineEvidence, TrackHistory
from echoplan.joint.map_extraction.endpoint_views import OFFSETS
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.factors import InformationPrior
from echoplan.joint.search.corner_echoes import CornerEcho
from echoplan.model import ClassProbabilities

__all__ = ["arrays_of", "prior_of_arrays"]

# Columns of ``histories``, numbers of a track history.
_NUMBERS = ("number", "llr", "best_llr", "supporting", "missing", "hidden", "passed", "pings", "certainty")
# Those that count something.
_COUNTS = frozenset(("number", "supporting", "missing", "hidden", "passed", "pings"))
_CLASSES = ("wall", "corner", "cylinder")
_ECHO = ("pings", "stations", "detections", "gain")


def arrays_of(prior: MarginalPrior) -> dict[str, FloatArray]:
    """Return what another recording needs of a prior: landmarks, their information and histories, noise and path.

    docs/formats.md describes the arrays.  Sonar, servo and poses are left out: they are those of one recording.
    """
    landmarks, histories = prior.features, [each.history for each in prior.features]
    information = prior.summary.marginalised_onto(np.arange(sum(len(each.parameters) for each in landmarks)))
    lines, driven = [each.line for each in histories], np.isfinite(prior.path_xy).all(axis=1)
    return {
        "landmarks": np.array([each.reflector for each in landmarks]).reshape(-1, 4),
        "extents": np.array([each.extent for each in landmarks]).reshape(-1, 2),
        "histories": _columns(histories, _NUMBERS),
        "probabilities": _columns([each.probabilities for each in histories], _CLASSES),
        "information": information.information,
        "information_vector": information.vector,
        **_ragged("feet", [each.feet for each in histories]),
        **_ragged("crossings", [each.crossings for each in histories]),
        **_ragged("line_feet", [each.feet for each in lines]),
        "line_centers": np.concatenate([np.zeros((0, 2)), *(each.centers_xy for each in lines)]),
        "line_log_ratios": np.concatenate(
            [np.zeros((0, 2, len(OFFSETS))), *(each.log_ratios for each in lines if len(each.feet))]
        ),
        "corner_pairs": np.array([*prior.echoes], dtype=np.float64).reshape(-1, 2),
        "corner_echoes": _columns(list(prior.echoes.values()), _ECHO),
        "noise_and_issued": np.array([prior.noise, prior.issued]),
        "path": prior.path_xy[driven],
        # Rows of NaN separate recordings.
        "path_of": np.cumsum(~driven, dtype=np.float64)[driven],
    }


def prior_of_arrays(arrays: Mapping[str, FloatArray]) -> MarginalPrior:
    """Return the prior of which the arrays were made.

    Raises
    ------
    InvalidValueError
        If an array is missing or does not fit the others; the message names it.
    """
    checked = _Checked(arrays)
    reflectors = checked("landmarks", None, 4)
    count, kinds = len(reflectors), reflectors[:, 0].astype(np.int64)
    if not np.isin(kinds, [int(kind) for kind in Kind]).all():
        raise InvalidValueError("landmarks has a class that is not known")
    size, at = int(PARAMETERS[kinds].sum()), checked("line_feet_of", None)
    lines = (checked("line_feet", len(at)), checked("line_centers", len(at), 2))
    ratios = checked("line_log_ratios", len(at), 2, len(OFFSETS))
    feet, crossings = (_parts(checked, name, count) for name in ("feet", "crossings"))
    extents, numbers = checked("extents", count, 2), checked("histories", count, len(_NUMBERS))
    probabilities = checked("probabilities", count, len(_CLASSES))
    histories = [
        TrackHistory(
            **{name: _number(name, value) for name, value in zip(_NUMBERS, numbers[place], strict=True)},
            extent=_pair(extents[place]) if kinds[place] == Kind.WALL else NO_HISTORY.extent,
            feet=feet[place],
            crossings=crossings[place],
            line=LineEvidence(*(each[at == place] for each in (*lines, ratios))),
            probabilities=ClassProbabilities(
                **dict(zip(_CLASSES, map(float, probabilities[place]), strict=True)),
            ),
        )
        for place in range(count)
    ]
    pairs = checked("corner_pairs", None, 2).astype(np.int64)
    echoes = checked("corner_echoes", len(pairs), len(_ECHO))
    noise, issued = checked("noise_and_issued", 2)
    return MarginalPrior(
        features=[
            _landmark(reflector, extent=_pair(extent), history=history)
            for reflector, extent, history in zip(reflectors, extents, histories, strict=True)
        ],
        summary=InformationPrior(
            np.arange(size), checked("information", size, size), checked("information_vector", size)
        ),
        echoes={
            (int(one), int(other)): CornerEcho(
                pings=int(echo[0]), stations=int(echo[1]), detections=float(echo[2]), gain=float(echo[3])
            )
            for (one, other), echo in zip(pairs, echoes, strict=True)
        },
        noise=float(noise),
        issued=int(issued),
        path_xy=_path(checked),
    )


class _Checked:
    """Looks up arrays and checks their shapes."""

    def __init__(self, arrays: Mapping[str, FloatArray]) -> None:
        self._arrays = arrays

    def __call__(self, name: str, *shape: int | None) -> FloatArray:
        """Return an array of a shape, of which None leaves a length open."""
        if name not in self._arrays:
            raise InvalidValueError(f"{name} is missing")
        return checked_floats(self._arrays[name], name=name, shape=shape)


def _columns(values: Sequence[object], names: Sequence[str]) -> FloatArray:
    """Return the named numbers of some values, one row each."""
    rows = np.array([[getattr(each, name) for name in names] for each in values], dtype=np.float64)
    return rows.reshape(-1, len(names))


def _ragged(name: str, rows: list[FloatArray]) -> dict[str, FloatArray]:
    """Return arrays of different lengths as one, and which of them each value is of."""
    of = np.repeat(np.arange(len(rows), dtype=np.float64), [len(row) for row in rows])
    return {name: np.concatenate([np.zeros(0), *rows]), f"{name}_of": of}


def _parts(checked: _Checked, name: str, count: int) -> list[FloatArray]:
    """Return what ``_ragged`` joined."""
    values = checked(name, None)
    of = checked(f"{name}_of", len(values))
    return [values[of == place] for place in range(count)]


def _path(checked: _Checked) -> FloatArray:
    """Return the path of several recordings, with a row of NaN between them."""
    path_xy = checked("path", None, 2)
    of = checked("path_of", len(path_xy))
    return np.insert(path_xy, np.flatnonzero(np.diff(of)) + 1, np.nan, axis=0)


def _pair(both: FloatArray) -> tuple[float, float]:
    return float(both[0]), float(both[1])


def _number(name: str, value: float) -> Any:
    return int(value) if name in _COUNTS else float(value)


def _landmark(reflector: FloatArray, *, extent: tuple[float, float], history: TrackHistory) -> Hypothesis:
    return Hypothesis(
        reflector=reflector,
        ping_scores=NO_PING_SCORES,
        llr_by_station=np.zeros(0),
        llr=history.llr,
        extent=extent,
        history=history,
    )
