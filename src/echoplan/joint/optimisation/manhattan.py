"""The Manhattan-world prior: walls stand at right angles to each other, and perhaps along the axes of the map."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.factors import LinearFactor, prior
from echoplan.joint.optimisation.layout import Layout
from echoplan.joint.optimisation.variance_components import map_scale_factor

__all__ = [
    "ManhattanPrior",
    "ManhattanSettings",
    "estimate_right_angles",
    "main_direction",
    "manhattan_factor",
    "manhattan_residual",
    "rest_on_few_stations",
    "roughly_square",
]

# Density of the direction of a wall that is not square to others: it may be any [1/rad].
_ANY = 2.0 / math.pi
# Rounds of expectation and maximisation.
_ROUNDS = 30
# Walls whose chance to be square is less stay as they are.
_LIKELY = 0.9
# So many stations leave it open how a wall lies that they were the only ones to hear.
_FEW = 2
# A share below this tells nothing of the direction of others.
_NEVER = 1e-6

# Any wall is known to a radian at least: its arcs say so [1/rad^2].
_LEAST_KNOWN = 1.0


class ManhattanSettings(BaseModel, frozen=True, extra="forbid"):
    """When right angles are believed in."""

    concentration: float = Field(
        default=0.8, gt=0.0, le=1.0, description="of the directions of walls, folded by right angles, from which on"
    )
    least_walls: int = Field(default=4, ge=2, description="from which anything follows")
    within: float = Field(default=math.radians(12), gt=0.0, description="of the main direction counts as square [rad]")
    sigma: float = Field(default=math.radians(1), gt=0.0, description="of such walls about it [rad]")
    cost: float = Field(default=100.0, ge=0.0, description="of a wall that is not square [nats]")
    tolerance: float = Field(
        default=math.radians(0.2), gt=0.0, description="of walls that were built square: 8 mm in 2 m (DIN 18202) [rad]"
    )
    spread: float = Field(
        default=0.5 * math.log(10.0), gt=0.0, description="deviation of its logarithm: a guess good to tenfold"
    )
    evidence: float = Field(default=3.0, ge=0.0, description="that walls are square, from which on it counts [nats]")
    measured: float = Field(
        default=0.9, gt=0.0, lt=1.0, description="chance that who set way-points by hand measured along square walls"
    )


class ManhattanPrior(NamedTuple):
    """Which walls stand at right angles to each other, and how exactly.

    Attributes
    ----------
    members : ndarray of bool, shape (f,)
        Which.
    sigma : float
        Standard deviation of these about the direction that they have in common [rad].
    along_axes : bool
        Whether that is the direction of the axes of the map; else it may be any.
    """

    members: BoolArray
    sigma: float
    along_axes: bool = False


def main_direction(features: Sequence[Hypothesis], settings: ManhattanSettings) -> float | None:
    """Find the direction to which, or across which, most walls stand.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there.
    settings : ManhattanSettings
        When right angles are believed in.

    Returns
    -------
    float or None
        Direction of a normal [rad], modulo a right angle; None where the walls do not support one.
    """
    walls = [each for each in features if each.is_wall]
    if len(walls) < settings.least_walls:
        return None
    llr_by_station = np.array([each.total for each in walls])
    mean = np.sum(llr_by_station * np.exp(4j * np.array([each.line[0] for each in walls]))) / llr_by_station.sum()
    return float(np.angle(mean)) / 4 if abs(mean) > settings.concentration else None


def roughly_square(
    features: Sequence[Hypothesis], settings: ManhattanSettings, *, may_lie_along_axes: bool
) -> ManhattanPrior | None:
    """Take walls near the main direction for square, while way-points are too wrong to tell.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there.
    settings : ManhattanSettings
        How near, and how exactly.
    may_lie_along_axes : bool
        Whether they are taken to stand along the axes of the map if these are near and most measure from such walls.

    Returns
    -------
    ManhattanPrior or None
        None where there is no main direction.
    """
    direction = main_direction(features, settings)
    if direction is None:
        return None
    off = manhattan_residual(np.array([each.reflector[1] for each in features]), direction)
    walls = np.array([each.is_wall for each in features])
    is_near = abs(float(manhattan_residual(np.array([direction]), 0.0)[0])) < settings.within
    along_axes = may_lie_along_axes and is_near and settings.measured > 0.5
    return ManhattanPrior(walls & (np.abs(off) < settings.within), settings.sigma, along_axes)


def rest_on_few_stations(features: Sequence[Hypothesis], least: float) -> bool:
    """Tell whether most walls were heard from one station or two: set elsewhere, these leave it open how walls lie.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there.
    least : float
        What a station must gain to count [nats].

    Returns
    -------
    bool
        Whether they were.
    """
    walls = [each for each in features if each.is_wall]
    return 2 * sum(each.supporting(least) <= _FEW for each in walls) > len(walls)


def estimate_right_angles(
    reflectors: FloatArray,
    layout: Layout,
    covariance: FloatArray,
    settings: ManhattanSettings,
    applied: ManhattanPrior | None = None,
    *,
    by_hand: bool = False,
) -> ManhattanPrior | None:
    r"""Tell which walls stand square to each other, and how exactly, if they do.

    A wall stands either at right angles to the direction d that square walls have in common, but for a deviation of
    s (``sigma``), or anyhow; any share of the walls may be square.  Walls that a station in error turns together are
    known far better against each other than each of them is, so each is held against what the others say of its
    direction, with the covariance of all.  Who is square, s and the share come by expectation and maximisation
    (Dempster, Laird and Rubin 1977), s with a prior whose logarithm is normal.  With C of what is not known of the m
    square ones of n walls, P the inverse of :math:`C + s^2 I`, and their deviations :math:`\delta` about d as P
    weighs them, the evidence that these are square is

    .. math:: \tfrac12 \ln \frac{|P|}{1^T P 1} - \tfrac12 \delta^T P \delta
              + (m - 1) \ln \frac{\pi / 2}{\sqrt{2 \pi}} - \ln \Bigl((n + 1) \binom{n}{m}\Bigr)

    less the logarithm of how likely it is, now, that just these are.

    Who sets way-points by hand mostly measures from the walls: then these stand along the axes of the map.  Else the
    map may lie anyhow, and d is any.  With the mean direction as P weighs it, off the axes by
    :math:`\bar\delta`, and :math:`v = 1 / 1^T P 1`, the logarithm of the odds of that is, from odds o on,

    .. math:: \ln o + \ln \frac{\pi / 2}{\sqrt{2 \pi v}} - \frac{\bar\delta^2}{2 v}

    Parameters
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters of features.
    layout : Layout
        Where these stand among the unknowns.
    covariance : ndarray, shape (u, u)
        Of all unknowns.
    settings : ManhattanSettings
        What is believed.
    applied : ManhattanPrior, optional
        The belief in right angles with which these came about, all of which is taken back first.
    by_hand : bool, optional
        Whether the frame of the map is that of way-points which somebody set by hand.

    Returns
    -------
    ManhattanPrior or None
        None where that explains the directions no better than chance.
    """
    walls = np.flatnonzero(layout.kinds == Kind.WALL)
    if len(walls) < settings.least_walls:
        return None
    angles, places = reflectors[walls, 1], layout.starts[walls]
    covariance = covariance[np.ix_(places, places)]
    if applied is not None:
        angles, covariance = _released(angles, covariance, applied._replace(members=applied.members[walls]))
    folded = np.stack([manhattan_residual(angles, float(each)) for each in angles])
    square = _normal(folded, np.diag(covariance) + settings.tolerance**2)
    first = int(np.argmax(np.log(square + _ANY).sum(axis=1)))
    shares, sigma = _are_confirmed(folded[first], covariance, square[first] / (square[first] + _ANY), settings)
    if _evidence(folded[first], covariance, shares, sigma) <= settings.evidence:
        return None
    members, square_ones = np.zeros(len(reflectors), dtype=bool), np.flatnonzero(shares > _LIKELY)
    members[walls[square_ones]] = True
    known = covariance[np.ix_(square_ones, square_ones)] + sigma**2 * np.eye(len(square_ones))
    return ManhattanPrior(members, sigma, by_hand and _are_along_axes(angles[square_ones], known, settings))


def _are_confirmed(
    off: FloatArray, covariance: FloatArray, shares: FloatArray, settings: ManhattanSettings
) -> tuple[FloatArray, float]:
    """Tell how likely each wall stands square, and how exactly these do, from how likely they seem at first."""
    sigma = settings.tolerance
    for _ in range(_ROUNDS):
        loose = sigma**2 / np.maximum(shares, _NEVER)
        precision = _contrasts(covariance + np.diag(loose))
        pulls = precision @ off
        # Of each deviation its square, and its variance; then what the other walls say of this one.
        expected = (loose * pulls) ** 2 + loose - loose**2 * np.diag(precision)
        square = _normal(pulls / np.diag(precision), 1.0 / np.diag(precision) - loose + sigma**2)
        sigma = settings.tolerance * float(
            map_scale_factor(float(shares @ expected) / settings.tolerance**2, float(shares.sum()), settings.spread)
        )
        odds = (shares.sum() + 1.0) / (len(shares) - shares.sum() + 1.0) * square / _ANY
        shares = odds / (1.0 + odds)
    return shares, sigma


def _are_along_axes(angles: FloatArray, covariance: FloatArray, settings: ManhattanSettings) -> bool:
    """Tell whether square walls stand along the axes of a map whose frame somebody measured."""
    weights = np.linalg.solve(covariance, np.ones(len(angles)))
    variance = 1.0 / float(weights.sum())
    off = variance * float(weights @ manhattan_residual(angles, 0.0))
    odds = math.log(settings.measured / (1.0 - settings.measured))
    gain = -0.5 * (math.log(2.0 * math.pi * variance * _ANY**2) + off**2 / variance)
    return odds + gain > settings.evidence


def _released(angles: FloatArray, covariance: FloatArray, applied: ManhattanPrior) -> tuple[FloatArray, FloatArray]:
    """Tell where walls would turn, and how well that would be known, if nobody believed in right angles.

    One step of Gauss and Newton without the rows of that belief.  Let go for good, walls of stations that nothing else
    holds would turn until other features explain what they explained.
    """
    rows = manhattan_factor(applied, angles, np.arange(len(angles)))
    jacobian = np.zeros((len(rows.residuals), len(angles)))
    np.add.at(jacobian, (np.arange(len(jacobian))[:, None], rows.columns), rows.jacobian)
    # What the model of the sonar lacks is in the covariance, too: so more may be taken back than it shows to be known.
    known, axes = np.linalg.eigh(np.linalg.inv(covariance) - jacobian.T @ (rows.weights[:, None] * jacobian))
    free: FloatArray = (axes / np.maximum(known, _LEAST_KNOWN)) @ axes.T
    return angles - free @ (jacobian.T @ (rows.weights * rows.residuals)), free


def _normal(off: FloatArray, variances: FloatArray) -> FloatArray:
    """Density of normal deviations."""
    density: FloatArray = np.exp(-0.5 * off**2 / variances) / np.sqrt(2.0 * np.pi * variances)
    return density


def _contrasts(covariance: FloatArray) -> FloatArray:
    """Precision of directions against each other: what they have in common may be anything."""
    precision = np.linalg.inv(covariance)
    common = precision.sum(axis=1)
    about: FloatArray = precision - np.outer(common, common) / common.sum()
    return about


def _evidence(off: FloatArray, covariance: FloatArray, shares: FloatArray, sigma: float) -> float:
    """Logarithm of how much likelier directions are if some walls are square than if none is."""
    members = shares > _LIKELY
    m, n = int(members.sum()), len(members)
    if m < 2:
        return -math.inf
    covariance = covariance[np.ix_(members, members)] + sigma**2 * np.eye(m)
    squares = float(off[members] @ _contrasts(covariance) @ off[members])
    volume = float(np.linalg.slogdet(covariance).logabsdet) + math.log(np.linalg.solve(covariance, np.ones(m)).sum())
    # Just these of all that could be, at first and now.
    chosen = math.log((n + 1) * math.comb(n, m)) + float(np.log(np.maximum(shares, 1.0 - shares)).sum())
    return -0.5 * (volume + squares) - (m - 1) * math.log(math.sqrt(2.0 * math.pi) * _ANY) - chosen


def manhattan_factor(applied: ManhattanPrior, angles: FloatArray, columns: IntArray) -> LinearFactor:
    """Draw walls to the direction that they have in common: that of the axes, or whatever it is.

    Parameters
    ----------
    applied : ManhattanPrior
        Which of them; at least one.
    angles : ndarray, shape (f,)
        Directions of their normals [rad]; of features that are no walls anything.
    columns : ndarray of int, shape (f,)
        Where these stand among the unknowns.

    Returns
    -------
    LinearFactor
        One a member; unless they stand along the axes they say nothing of the direction.
    """
    members = np.flatnonzero(applied.members)
    if applied.along_axes:
        return prior(columns[members], sigma=applied.sigma, residual=-manhattan_residual(angles[members], 0.0))
    off = manhattan_residual(angles[members], float(angles[members[0]]))
    return LinearFactor(
        columns=np.tile(columns[members], (len(members), 1)),
        jacobian=np.eye(len(members)) - 1.0 / len(members),
        residuals=off.mean() - off,
        weights=np.full(len(members), applied.sigma**-2.0),
    )


def manhattan_residual(angles: FloatArray, direction: float) -> FloatArray:
    """Tell by how much walls are off the nearest square direction.

    Parameters
    ----------
    angles : ndarray, shape (w,)
        Directions of their normals [rad].
    direction : float
        The main direction [rad].

    Returns
    -------
    ndarray, shape (w,)
        Within 45 degrees [rad].

    Examples
    --------
    >>> np.degrees(manhattan_residual(np.radians([93.0, 178.0]), 0.0)).round(6)
    array([ 3., -2.])
    """
    off: FloatArray = wrap(4.0 * (angles - direction)) / 4.0
    return off
