from dataclasses import replace

from echoplan.joint.likelihood_cache import LikelihoodCache
from echoplan.joint.optimisation.sonar_model import expected_sonar
from echoplan.preprocessing.measurements import measurements_of
from echoplan.sources import open_source

SOURCE = open_source("sim:square")
PINGS = measurements_of(next(iter(SOURCE)), SOURCE.rig)
MODEL = expected_sonar(SOURCE.rig, PINGS)


def test_a_likelihood_is_computed_once_for_the_same_pings_model_and_noise() -> None:
    cache = LikelihoodCache()
    noise = 0.002
    first = cache.of(PINGS, MODEL, noise=noise)
    assert cache.of(PINGS, MODEL, noise=noise) is first
    others = (
        cache.of(PINGS._replace(), MODEL, noise=noise),
        cache.of(PINGS, replace(MODEL), noise=noise),
        cache.of(PINGS, MODEL, noise=0.004),
    )
    assert all(each is not first for each in others)
    assert cache.of(PINGS, MODEL, noise=noise) is first
