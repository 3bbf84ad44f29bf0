"""The marginal prior as plain arrays, as a file of a map holds it, so that another recording can go on from it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, checked_floats
from echoplan.errors import InvalidValueError
from echoplan.joint.landmarks import PARAMETERS
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES
from echoplan.joint.likelihood.track_history import LineEvidence, TrackHistory
from echoplan.joint.map_extraction.endpoint_views import OFFSETS
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.factors import InformationPrior
from echoplan.joint.search.corner_echoes import CornerEcho
from echoplan.model import ClassProbabilities

__all__ = ["arrays_of", "prior_of_arrays"]

# Columns of ``histories``, numbers of a track history, and their types.
_NUMBERS = ("number", "recording", "llr", "best_llr", "supporting", "missing", "hidden", "passed", "pings", "certainty")
_MAKE = (int, int, float, float, int, int, int, int, int, float)
_CLASSES = ("wall", "corner", "cylinder")
_ECHO = ("pings", "stations", "detections", "gain")


def arrays_of(prior: MarginalPrior) -> dict[str, FloatArray]:
    """Return what another recording needs of a prior: landmarks, their information and histories, noise and path.

    docs/formats.md describes the arrays.  Sonar, servo and poses are left out: they are those of one recording.
    """
    landmarks, driven = prior.features, np.isfinite(prior.path_xy).all(axis=1)
    information = prior.summary.marginalised_onto(np.arange(sum(len(each.parameters) for each in landmarks)))
    return {
        "landmarks": np.array([each.reflector for each in landmarks]).reshape(-1, 4),
        "extents": np.array([each.extent for each in landmarks]).reshape(-1, 2),
        **_arrays_of_histories([each.history for each in landmarks]),
        "information": information.information,
        "information_vector": information.vector,
        "corner_pairs": np.array([*prior.echoes], dtype=np.float64).reshape(-1, 2),
        "corner_echoes": _columns(list(prior.echoes.values()), _ECHO),
        "numbers": np.array([prior.noise, prior.issued, prior.model.range_scale if prior.model else prior.range_scale]),
        # Rows of NaN separate recordings.
        "path": prior.path_xy[driven],
        "path_of": np.cumsum(~driven, dtype=np.float64)[driven],
    }


def _arrays_of_histories(histories: Sequence[TrackHistory]) -> dict[str, FloatArray]:
    lines = [each.line for each in histories]
    return {
        "histories": _columns(histories, _NUMBERS),
        "probabilities": _columns([each.probabilities for each in histories], _CLASSES),
        **_ragged("feet", [each.feet for each in histories]),
        **_ragged("crossings", [each.crossings for each in histories]),
        **_ragged("line_feet", [each.feet for each in lines]),
        "line_centers": np.concatenate([np.zeros((0, 2)), *(each.centers_xy for each in lines)]),
        "line_log_ratios": np.concatenate(
            [np.zeros((0, 2, len(OFFSETS))), *(each.log_ratios for each in lines if len(each.feet))]
        ),
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
    kinds = reflectors[:, 0].astype(np.int64)
    if not np.isin(reflectors[:, 0], [int(kind) for kind in Kind]).all():
        raise InvalidValueError("landmarks has a class that is not known")
    size, extents = int(PARAMETERS[kinds].sum()), checked("extents", len(kinds), 2)
    (noise, issued, range_scale), path_xy = checked("numbers", 3), checked("path", None, 2)
    information = checked("information", size, size)
    scale = float(np.abs(information).max(initial=1.0))
    if not np.allclose(information, information.T, rtol=0.0, atol=1e-9 * scale) or (
        size and np.linalg.eigvalsh(information)[0] < -1e-9 * scale
    ):
        raise InvalidValueError("information must be symmetric, without negative eigenvalues")
    return MarginalPrior(
        features=[
            Hypothesis(
                reflector=reflector,
                ping_scores=NO_PING_SCORES,
                llr_by_station=np.zeros(0),
                llr=history.llr,
                extent=(low, high),
                # Points have no extent.
                history=replace(history, extent=(low, high)) if reflector[0] == Kind.WALL else history,
            )
            for reflector, (low, high), history in zip(
                reflectors, extents.tolist(), _histories(checked, len(kinds)), strict=True
            )
        ],
        summary=InformationPrior(np.arange(size), information, checked("information_vector", size)),
        echoes=_corner_echoes(checked),
        noise=float(noise),
        issued=int(issued),
        range_scale=float(range_scale),
        # Rows of NaN separate recordings.
        path_xy=np.insert(path_xy, np.flatnonzero(np.diff(checked("path_of", len(path_xy)))) + 1, np.nan, axis=0),
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


def _histories(checked: _Checked, count: int) -> list[TrackHistory]:
    """Return the track histories of ``count`` landmarks, without the extents of walls."""
    of = checked("line_feet_of", None)
    lines = (checked("line_feet", len(of)), checked("line_centers", len(of), 2))
    ratios = checked("line_log_ratios", len(of), 2, len(OFFSETS))
    columns = (
        checked("histories", count, len(_NUMBERS)),
        checked("probabilities", count, len(_CLASSES)).tolist(),
        _parts(checked, "feet", count),
        _parts(checked, "crossings", count),
    )
    return [
        TrackHistory(
            **dict(zip(_NUMBERS, (make(value) for make, value in zip(_MAKE, row, strict=True)), strict=True)),
            feet=feet,
            crossings=crossings,
            line=LineEvidence(*(each[of == place] for each in (*lines, ratios))),
            probabilities=ClassProbabilities(**dict(zip(_CLASSES, chances, strict=True))),
        )
        for place, (row, chances, feet, crossings) in enumerate(zip(*columns, strict=True))
    ]


def _corner_echoes(checked: _Checked) -> dict[tuple[int, int], CornerEcho]:
    pairs = checked("corner_pairs", None, 2).astype(np.int64).tolist()
    rows = checked("corner_echoes", len(pairs), len(_ECHO)).tolist()
    return {
        (one, other): CornerEcho(pings=int(pings), stations=int(stations), detections=detections, gain=gain)
        for (one, other), (pings, stations, detections, gain) in zip(pairs, rows, strict=True)
    }


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
