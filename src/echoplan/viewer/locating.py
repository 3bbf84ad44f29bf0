"""Localisations in words."""

import math

from echoplan.model import HALF_OF_95, Localisation, Quality, Verdict

__all__ = ["localisation_lines"]


def localisation_lines(localisation: Localisation, quality: Quality) -> tuple[str, ...]:
    """Say where a recording was made in a map, and whether that can be trusted, a line each.

    Parameters
    ----------
    localisation : Localisation
        The poses.
    quality : Quality
        Whether they can be trusted.

    Returns
    -------
    tuple of str
        The verdict first.
    """
    step = (f"Next step: {quality.next_step}",) if quality.next_step else ()
    verdict = "Located" if quality.verdict is Verdict.GOOD else "Located, but doubtful"
    headline = f"{verdict}: echoes and map agree to {localisation.percent_in_common} %."
    sweeps = localisation.sweeps.tolist()
    elsewhere = (
        f"The robot was carried elsewhere between sweeps {sweeps[sweeps.index(each) - 1]} and {each}."
        for each in localisation.kidnapped
    )
    ends = (f"{name}: {_pose(localisation, place)}" for name, place in (("First pose", 0), ("Last pose", -1)))
    return (headline, *quality.reasons, *step, *elsewhere, *ends)


def _pose(localisation: Localisation, place: int) -> str:
    x, y, yaw = localisation.poses[place]
    sigmas = localisation.covariances[place].diagonal() ** 0.5
    position = f"x {x:.3f} ± {HALF_OF_95 * sigmas[0]:.3f} m, y {y:.3f} ± {HALF_OF_95 * sigmas[1]:.3f} m"
    # Adding zero makes a positive zero of a negative one.
    return f"{position}, yaw {round(math.degrees(yaw), 2) + 0.0:.2f} ± {math.degrees(HALF_OF_95 * sigmas[2]):.2f}°"
