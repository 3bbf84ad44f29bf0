"""Lines that grow surer: the Kalman update of a static line by each further segment of it.

The state is ``(normal_angle, offset)``; a segment measures it directly, so that with the innovation y and
``K = P (P + R)**-1`` the update is ``x + K y`` and ``(I - K) P``.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.points import Segment
from echoplan.geometry import along, wrap
from echoplan.settings import Settings

__all__ = ["KalmanSettings", "Track", "merged", "misfits", "tracked", "update"]


class KalmanSettings(Settings):
    """When two segments are of one line."""

    gate: float = Field(
        default=9.21,
        gt=0.0,
        description="Largest squared Mahalanobis distance between segments of one line: 99 % of a chi-square of two.",
    )
    max_gap: float = Field(default=0.7, ge=0.0, description="Largest gap between segments of one wall [m].")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Track:
    """A line and the sweeps that measured it.

    Parameters
    ----------
    segment : Segment
        The line so far.
    sweeps : frozenset of int
        Numbers of the sweeps.
    """

    segment: Segment
    sweeps: frozenset[int]


def update(segment: Segment, measured: Segment) -> Segment:
    """Correct a line by another measurement of it.

    Parameters
    ----------
    segment, measured : Segment
        Two segments of one line, their normals to the same side.

    Returns
    -------
    Segment
        The line between them, surer than either, as long as both together.
    """
    gain = segment.covariance @ np.linalg.inv(segment.covariance + measured.covariance)
    innovation = measured.line - segment.line
    line = segment.line + gain @ [wrap(innovation[0]), innovation[1]]
    covariance = segment.covariance - gain @ segment.covariance
    ends = along(line, np.concatenate([segment.ends_xy, measured.ends_xy]))
    return Segment(
        line=np.array([wrap(line[0]), line[1]]),
        covariance=(covariance + covariance.T) / 2,
        low=float(ends.min()),
        high=float(ends.max()),
        members=np.concatenate([segment.members, measured.members]),
        stations=max(segment.stations, measured.stations),
    )


def misfits(segments: Sequence[Segment], measured: Segment, settings: KalmanSettings) -> FloatArray:
    """Squared Mahalanobis distances of a measurement from several lines.

    Parameters
    ----------
    segments : sequence of Segment
        The lines.
    measured : Segment
        The measurement.
    settings : KalmanSettings
        How far apart they may be along the line.

    Returns
    -------
    ndarray, shape (n,)
        Squared Mahalanobis distances of ``(normal_angle, offset)``; infinite where the gap is too wide.
    """
    if not segments:
        return np.zeros(0)
    lines = np.array([segment.line for segment in segments])
    covariances = np.array([segment.covariance for segment in segments]) + measured.covariance
    innovations = np.stack([wrap(measured.line[0] - lines[:, 0]), measured.line[1] - lines[:, 1]], axis=-1)
    squares = np.sum(innovations * np.linalg.solve(covariances, innovations[..., None])[..., 0], axis=1)
    ends = along(lines[:, None], measured.ends_xy)
    bounds = np.array([[segment.low, segment.high] for segment in segments])
    gaps = np.maximum(ends.min(axis=1) - bounds[:, 1], bounds[:, 0] - ends.max(axis=1))
    return np.where(gaps <= settings.max_gap, squares, np.inf)


def tracked(tracks: list[Track], measured: Track, settings: KalmanSettings) -> list[Track]:
    """Let a measurement update the line that it fits best, or open another.

    Parameters
    ----------
    tracks : list of Track
        The lines so far.
    measured : Track
        A new segment.
    settings : KalmanSettings
        What fits.

    Returns
    -------
    list of Track
        The lines with it.
    """
    apart = misfits([track.segment for track in tracks], measured.segment, settings)
    if not (apart <= settings.gate).any():
        return [*tracks, measured]
    best = int(np.argmin(apart))
    joined = Track(segment=update(tracks[best].segment, measured.segment), sweeps=tracks[best].sweeps | measured.sweeps)
    return [*tracks[:best], joined, *tracks[best + 1 :]]


def merged(tracks: Iterable[Track], settings: KalmanSettings) -> list[Track]:
    """Merge lines that turned out to be one.

    Parameters
    ----------
    tracks : iterable of Track
        The lines.
    settings : KalmanSettings
        What fits.

    Returns
    -------
    list of Track
        Lines of which no two fit.
    """
    before = list(tracks)
    while True:
        after: list[Track] = []
        for track in before:
            after = tracked(after, track, settings)
        if len(after) == len(before):
            return after
        before = after
