"""The Manhattan-world prior: walls at right angles to each other, and possibly along the axes of the map."""

import math
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.factors import LinearFactor, prior
from echoplan.joint.optimisation.layout import Layout
from echoplan.joint.optimisation.variance_components import map_scale_factor
from echoplan.settings import Settings

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

# Density of the direction of a wall that is not square to others: uniform over a right angle [1/rad].
_ANY = 2.0 / math.pi
# Iterations of expectation-maximisation.
_ROUNDS = 30
# Probability from which a wall counts as square.
_LIKELY = 0.9
# This many stations alone do not determine the direction of a wall.
_FEW = 2
# Lower bound of the probability of a wall to be square, so that weights stay finite.
_NEVER = 1e-6

# Lower bound of the information on the direction of a wall: arcs determine it to a radian at least [1/rad^2].
_LEAST_KNOWN = 1.0


class ManhattanSettings(Settings):
    """Settings of the Manhattan prior."""

    former_keys: ClassVar = {
        "concentration": "min_circular_concentration",
        "least_walls": "min_walls",
        "within": "inlier_angle",
        "cost": "min_llr_if_oblique",
        "spread": "log_sigma",
        "evidence": "min_log_odds",
        "measured": "prior_axis_aligned",
    }

    # Smallest resultant length of the directions of walls, modulo 90 degrees, at which a room is rectangular.
    min_circular_concentration: ClassVar[float] = 0.8
    # Smallest number of walls of a rectangular room.
    min_walls: ClassVar[int] = 4
    # Largest angle from the main direction, modulo 90 degrees, of a wall that counts as square to it [rad].
    inlier_angle: ClassVar[float] = math.radians(12)
    sigma: float = Field(
        default=math.radians(1),
        gt=0.0,
        description="Standard deviation of such walls about the main direction while poses are wrong [rad].",
    )
    # Smallest log-likelihood ratio of a wall that is oblique to the main direction [nats].
    min_llr_if_oblique: ClassVar[float] = 100.0
    # Expected standard deviation of walls that are built at right angles [rad]: 8 mm in 2 m (DIN 18202).
    tolerance: ClassVar[float] = math.radians(0.2)
    # Standard deviation of the logarithm of the tolerance: two of them are a factor of ten.
    log_sigma: ClassVar[float] = 0.5 * math.log(10.0)
    # Smallest log odds of a rectangular room with which right angles are used [nats].
    min_log_odds: ClassVar[float] = 3.0
    prior_axis_aligned: float = Field(
        default=0.9,
        gt=0.0,
        lt=1.0,
        description="Prior probability that waypoints set by hand were measured along walls at right angles.",
    )


class ManhattanPrior(NamedTuple):
    """Which walls are at right angles to each other, and with what standard deviation."""

    # Which features are such walls, shape (f,).
    members: BoolArray
    # Standard deviation of their directions about the common one [rad].
    sigma: float
    # Whether the common direction is that of the axes of the map; else it is free.
    along_axes: bool = False


def main_direction(features: Sequence[Hypothesis], settings: ManhattanSettings) -> float | None:
    """Return the direction to which most walls are normal or parallel [rad], modulo a right angle.

    Walls are weighted by their LLR. The result is None if there are too few walls or their directions differ too much.
    """
    walls = [each for each in features if each.is_wall]
    if len(walls) < settings.min_walls:
        return None
    llrs = np.array([each.llr for each in walls])
    mean = np.sum(llrs * np.exp(4j * np.array([each.line[0] for each in walls]))) / llrs.sum()
    return float(np.angle(mean)) / 4 if abs(mean) > settings.min_circular_concentration else None


def roughly_square(
    features: Sequence[Hypothesis], settings: ManhattanSettings, *, may_lie_along_axes: bool
) -> ManhattanPrior | None:
    """Return a Manhattan prior of the walls near the main direction, or None if there is no main direction.

    It serves while poses are too inaccurate for ``estimate_right_angles``. With ``may_lie_along_axes``, a main
    direction near the axes of the map is taken for theirs, since waypoints are mostly measured from such walls.
    """
    direction = main_direction(features, settings)
    if direction is None:
        return None
    off = manhattan_residual(np.array([each.reflector[1] for each in features]), direction)
    walls = np.array([each.is_wall for each in features])
    is_near = abs(float(manhattan_residual(np.array([direction]), 0.0)[0])) < settings.inlier_angle
    along_axes = may_lie_along_axes and is_near and settings.prior_axis_aligned > 0.5
    return ManhattanPrior(walls & (np.abs(off) < settings.inlier_angle), settings.sigma, along_axes)


def rest_on_few_stations(features: Sequence[Hypothesis], least: float) -> bool:
    """Return whether most walls have an LLR above ``least`` [nats] from no more than two stations.

    Errors of the poses of these stations leave the directions of such walls undetermined.
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
    r"""Return the walls at right angles to each other and their standard deviation, or None without evidence.

    A wall is either square to a common direction d with standard deviation s (``sigma``), or has any direction; any
    share of the walls may be square. A pose error turns all walls of a station together, so their directions relative
    to each other are known much better than each by itself. Each wall is therefore compared with the direction that the
    others predict for it, with the covariance of all. Membership, s and the share of square walls are estimated by
    expectation-maximisation (Dempster, Laird and Rubin 1977), s with a log-normal prior. With C, the covariance of the
    directions of the m square ones of n walls, P, the inverse of :math:`C + s^2 I`, and their deviations :math:`\delta`
    from the mean d weighted by P, the log evidence for these walls being square is

    .. math:: \tfrac12 \ln \frac{|P|}{1^T P 1} - \tfrac12 \delta^T P \delta
              + (m - 1) \ln \frac{\pi / 2}{\sqrt{2 \pi}} - \ln \Bigl((n + 1) \binom{n}{m}\Bigr)

    minus the log posterior probability of this membership.

    Waypoints placed by hand (``by_hand``) are mostly measured from the walls, which are then along the axes of the map.
    Otherwise the map may have any orientation, and d is free. With the mean deviation :math:`\bar\delta` from the axes,
    weighted by P, and :math:`v = 1 / 1^T P 1`, the log odds of walls along the axes are, with prior odds o,

    .. math:: \ln o + \ln \frac{\pi / 2}{\sqrt{2 \pi v}} - \frac{\bar\delta^2}{2 v}

    ``covariance``, shape (u, u), is that of all unknowns, and ``applied`` the prior that contributed to it and to
    ``reflectors``; its effect is removed first.
    """
    walls = np.flatnonzero(layout.kinds == Kind.WALL)
    if len(walls) < settings.min_walls:
        return None
    angles, places = reflectors[walls, 1], layout.starts[walls]
    covariance = covariance[np.ix_(places, places)]
    if applied is not None:
        angles, covariance = _released(angles, covariance, applied._replace(members=applied.members[walls]))
    folded = np.stack([manhattan_residual(angles, float(each)) for each in angles])
    square = _normal(folded, np.diag(covariance) + settings.tolerance**2)
    first = int(np.argmax(np.log(square + _ANY).sum(axis=1)))
    shares, sigma = _estimate_membership(folded[first], covariance, square[first] / (square[first] + _ANY), settings)
    if _evidence(folded[first], covariance, shares, sigma) <= settings.min_log_odds:
        return None
    members, square_ones = np.zeros(len(reflectors), dtype=bool), np.flatnonzero(shares > _LIKELY)
    members[walls[square_ones]] = True
    known = covariance[np.ix_(square_ones, square_ones)] + sigma**2 * np.eye(len(square_ones))
    return ManhattanPrior(members, sigma, by_hand and _are_along_axes(angles[square_ones], known, settings))


def _estimate_membership(
    off: FloatArray, covariance: FloatArray, shares: FloatArray, settings: ManhattanSettings
) -> tuple[FloatArray, float]:
    """Return the probability of each wall to be square, shape (w,), and the standard deviation of square walls [rad].

    Expectation-maximisation from initial probabilities ``shares``.
    """
    sigma = settings.tolerance
    for _ in range(_ROUNDS):
        loose = sigma**2 / np.maximum(shares, _NEVER)
        precision = _contrasts(covariance + np.diag(loose))
        pulls = precision @ off
        # Expected squares of the deviations, then the density of each deviation as predicted from the other walls.
        expected = (loose * pulls) ** 2 + loose - loose**2 * np.diag(precision)
        square = _normal(pulls / np.diag(precision), 1.0 / np.diag(precision) - loose + sigma**2)
        sigma = settings.tolerance * float(
            map_scale_factor(float(shares @ expected) / settings.tolerance**2, float(shares.sum()), settings.log_sigma)
        )
        odds = (shares.sum() + 1.0) / (len(shares) - shares.sum() + 1.0) * square / _ANY
        shares = odds / (1.0 + odds)
    return shares, sigma


def _are_along_axes(angles: FloatArray, covariance: FloatArray, settings: ManhattanSettings) -> bool:
    """Return whether square walls are along the axes of a map whose frame was measured by hand."""
    weights = np.linalg.solve(covariance, np.ones(len(angles)))
    variance = 1.0 / float(weights.sum())
    off = variance * float(weights @ manhattan_residual(angles, 0.0))
    odds = math.log(settings.prior_axis_aligned / (1.0 - settings.prior_axis_aligned))
    gain = -0.5 * (math.log(2.0 * math.pi * variance * _ANY**2) + off**2 / variance)
    return odds + gain > settings.min_log_odds


def _released(angles: FloatArray, covariance: FloatArray, applied: ManhattanPrior) -> tuple[FloatArray, FloatArray]:
    """Return the directions of walls and their covariance without the Manhattan prior that was applied.

    This is one Gauss-Newton step without the rows of the prior. A complete optimisation without it would turn walls of
    weakly connected stations until other landmarks explain their readings.
    """
    rows = manhattan_factor(applied, angles, np.arange(len(angles)))
    jacobian = np.zeros((len(rows.residuals), len(angles)))
    np.add.at(jacobian, (np.arange(len(jacobian))[:, None], rows.columns), rows.jacobian)
    # The covariance includes model errors, so the information of the prior may exceed its inverse: hence the bound.
    known, axes = np.linalg.eigh(np.linalg.inv(covariance) - jacobian.T @ (rows.weights[:, None] * jacobian))
    free: FloatArray = (axes / np.maximum(known, _LEAST_KNOWN)) @ axes.T
    return angles - free @ (jacobian.T @ (rows.weights * rows.residuals)), free


def _normal(off: FloatArray, variances: FloatArray) -> FloatArray:
    """Return the normal density of deviations."""
    density: FloatArray = np.exp(-0.5 * off**2 / variances) / np.sqrt(2.0 * np.pi * variances)
    return density


def _contrasts(covariance: FloatArray) -> FloatArray:
    """Return the information on directions relative to each other: their mean is marginalised with a flat prior."""
    precision = np.linalg.inv(covariance)
    common = precision.sum(axis=1)
    about: FloatArray = precision - np.outer(common, common) / common.sum()
    return about


def _evidence(off: FloatArray, covariance: FloatArray, shares: FloatArray, sigma: float) -> float:
    """Return the log-likelihood ratio of square walls against walls of uniform direction [nats]."""
    members = shares > _LIKELY
    m, n = int(members.sum()), len(members)
    if m < 2:
        return -math.inf
    covariance = covariance[np.ix_(members, members)] + sigma**2 * np.eye(m)
    squares = float(off[members] @ _contrasts(covariance) @ off[members])
    volume = float(np.linalg.slogdet(covariance).logabsdet) + math.log(np.linalg.solve(covariance, np.ones(m)).sum())
    # Negative log prior probability of this membership, and its log posterior probability.
    chosen = math.log((n + 1) * math.comb(n, m)) + float(np.log(np.maximum(shares, 1.0 - shares)).sum())
    return -0.5 * (volume + squares) - (m - 1) * math.log(math.sqrt(2.0 * math.pi) * _ANY) - chosen


def manhattan_factor(applied: ManhattanPrior, angles: FloatArray, columns: IntArray) -> LinearFactor:
    """Return the factor of square walls, one row each: deviation from the map axes, or from their common direction.

    ``columns``, shape (f,), are the positions of the normal angles. Without ``along_axes`` the common direction is
    unconstrained.
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
    """Return the deviation of normal angles from the nearest square direction, within 45 degrees [rad].

    Examples
    --------
    >>> np.degrees(manhattan_residual(np.radians([93.0, 178.0]), 0.0)).round(6)
    array([ 3., -2.])
    """
    off: FloatArray = wrap(4.0 * (angles - direction)) / 4.0
    return off
