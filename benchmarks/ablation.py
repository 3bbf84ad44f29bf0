"""What each special rule of joint is good for: python benchmarks/ablation.py [RULE ...] [--only KIND] [--share S].

Maps recordings of the kinds in ``library.populations`` with all rules, and again with one rule switched off at a time.
Prints, rule by rule, on how many recordings the map changes at all, and which measures become worse or better beyond
the tolerances of ``gate.py``: recall, precision, error and 95 % ellipses of walls, corners and cylinders, and CPU time.
A rule that changes nothing on the kind of recordings it was made for can be removed; a new rule needs a row here.

``--list`` prints the rules.  ``--hold-out`` takes recordings at which nobody looks while a rule is chosen.
"""

import argparse
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, evaluate
from echoplan.joint.estimate import Estimate
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Table
from library.paired import Scores, compare
from library.populations import POPULATIONS

_POSES, _SEARCH, _MAP = (f"echoplan.joint.{each}" for each in ("pose_correction", "search", "map_extraction"))
_MODELS, _ESTIMATE = "echoplan.joint.pose_model_selection", "echoplan.joint.estimate"
_MANHATTAN, _MARGINAL = "echoplan.joint.optimisation.manhattan", "echoplan.joint.marginalisation"


def _unchanged(index: int = 0) -> Callable[..., Any]:
    """Return a function that returns one of its arguments, a tuple as a list."""

    def function(*arguments: Any, **_: Any) -> Any:
        kept = arguments[index]
        return list(kept) if type(kept) is tuple else kept

    return function


def _constant(value: Any) -> Callable[..., Any]:
    return lambda *_, **__: value


def _initialised_once(estimate: Estimate) -> Estimate:
    return estimate.search(rounds=1).optimise(estimate.first_noise)


def _in_recorded_order(places_xy: Any) -> list[int]:
    return list(range(len(places_xy)))


# Rule: what is put in the place of which names while it is switched off.
RULES: Mapping[str, Mapping[str, Any]] = {
    # The search.
    "soft walls": {"echoplan.joint.likelihood.hypothesis._CLEAR_STATIONS": 10**6},
    "one wall or cylinder as several walls": {f"{_SEARCH}.search.split_joined_walls": _unchanged(1)},
    "other classes": {f"{_ESTIMATE}.reclassified": _unchanged(1)},
    "corner on walls": {f"{_SEARCH}.model_moves._spared_walls": _constant(0)},
    "corner for a short wall": {f"{_SEARCH}.model_moves._crossings": _constant([])},
    "boxes": {f"{_ESTIMATE}.with_boxes": _unchanged(1)},
    "classes again": {f"{_ESTIMATE}.Estimate.reselect_classes": _unchanged()},
    "latent walls": {f"{_SEARCH}.multipath_walls._without_latent": _unchanged(1)},
    "crosstalk over latent walls": {f"{_SEARCH}.multipath_walls._without_crosstalk": _unchanged(1)},
    "round walls": {"echoplan.joint.likelihood.proposals._round_walls": _constant(np.zeros((0, 3)))},
    "coarse refinement": {f"{_SEARCH}.search._SURE_STATIONS": 0},
    # The acceptance test.
    "more readings than parameters": {f"{_SEARCH}.acceptance.AcceptanceTest._is_overdetermined": _constant(value=True)},
    "cylinders are not missed": {f"{_SEARCH}.acceptance.AcceptanceTest._is_missed": _constant(value=False)},
    "two stations detect enough": {f"{_SEARCH}.acceptance.AcceptanceTest._is_detected": _constant(value=True)},
    "one station detects all": {f"{_SEARCH}.acceptance.AcceptanceTest._is_whole": _constant(value=True)},
    "round walls in enough directions": {f"{_SEARCH}.acceptance.AcceptanceTest._is_round": _constant(value=True)},
    # The optimisation.
    "first map again": {f"{_ESTIMATE}.Estimate.initialise": _initialised_once},
    "figure of merit and beam as variables": {f"{_ESTIMATE}.Estimate.refine_calibration": _unchanged()},
    "attenuation": {f"{_ESTIMATE}.shadowed": _unchanged(2)},
    # Poses.
    "corners face one way": {"echoplan.joint.likelihood.hypothesis._RIGHT_ANGLE": math.tau},
    "wheel slips": {f"{_MODELS}.without_wheel_slip": _constant(None)},
    "relocalisation": {f"{_MODELS}.relocalised": _constant(None)},
    "wider odometry": {f"{_MODELS}._may_exceed_specification": _constant(value=False)},
    "registration order": {f"{_MODELS}.spanning_tree_order": _in_recorded_order},
    "annealing": {f"{_MODELS}.anneal": _unchanged()},
    "wrong registrations": {f"{_MODELS}.without_greatest_error": _constant(None)},
    "estimated odometry noise": {f"{_POSES}.annealing.with_estimated_odometry_noise": _unchanged(1)},
    "duplicates": {f"{_POSES}.annealing._merged": _unchanged()},
    "weak oblique walls": {f"{_MANHATTAN}.ManhattanSettings.min_llr_if_oblique": -math.inf},
    "right angles": {
        f"{_POSES}.annealing.roughly_square": _constant(None),
        f"{_POSES}.annealing.estimate_right_angles": _constant(None),
        f"{_MARGINAL}.estimate_right_angles": _constant(None),
    },
    "estimated shared error of readings": {f"{_MODELS}.estimate_shared_bias": _unchanged()},
    # The map.
    "copies of segments": {f"{_MAP}.segments._without_copies": _unchanged()},
    "cuts at fronts": {f"{_MAP}.segments.fronts_of": _constant([])},
    "ends at corners": {f"{_MAP}.segments.corners_on": _constant([])},
    "bodies": {f"{_MAP}.bodies.Bodies.hide": lambda *arguments: 0.0 * arguments[1][:, 0]},
    "far-fetched corners": {f"{_MAP}.corners._is_far_fetched": _constant(value=False)},
    "corners past corners": {f"{_MAP}.corners._ends_before": _constant(value=False)},
}
ALL = "all rules"


@dataclass(frozen=True, slots=True, kw_only=True)
class Mapped:
    """One map: its numbers, its evaluation and the CPU time [s]."""

    numbers: list[Any]
    evaluation: Evaluation
    seconds: float


class Job(NamedTuple):
    """One recording and the rule that is switched off."""

    kind: str
    seed: int
    rule: str


def main() -> None:
    """Map everything, and print a table of the rules for each kind of recordings."""
    parser = argparse.ArgumentParser(description="What each special rule of joint is good for.")
    parser.add_argument("rules", nargs="*", metavar="RULE", help="rules to switch off; all by default")
    parser.add_argument("--only", default="", help="only kinds of recordings whose name contains this")
    parser.add_argument("--share", type=float, default=0.25, help="share of the recordings of each kind")
    parser.add_argument("--hold-out", action="store_true", help="other recordings")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--list", action="store_true", help="print the rules")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(RULES))
        return
    if unknown := [each for each in arguments.rules if each not in RULES]:
        parser.error(f"no rule {unknown[0]!r}: --list prints the rules")
    rules = arguments.rules or list(RULES)
    for kind, population in POPULATIONS.items():
        if arguments.only in kind:
            seeds = population.seeds(hold_out=arguments.hold_out)[: math.ceil(arguments.share * population.size)]
            show(table(kind, map_all(kind, seeds, rules, arguments.workers)))


def map_all(kind: str, seeds: Sequence[int], rules: Sequence[str], workers: int) -> dict[str, list[Mapped]]:
    """Map recordings with all rules and without each of them."""
    jobs = [Job(kind, seed, rule) for rule in (ALL, *rules) for seed in seeds]
    # Loading the compiled code is no part of the time of the first map.
    with ProcessPoolExecutor(workers, initializer=run, initargs=(jobs[0],)) as pool:
        maps = list(tracked(pool.map(run, jobs), total=len(jobs), task=f"mapping {kind}"))
    found: dict[str, list[Mapped]] = {}
    for job, each in zip(jobs, maps, strict=True):
        found.setdefault(job.rule, []).append(each)
    return found


def run(job: Job) -> Mapped:
    """Simulate and map one recording with a rule switched off, and evaluate the map."""
    population = POPULATIONS[job.kind]
    recording = population.make(job.seed)
    sweeps = tuple(recording)
    settings = JointSettings(poses=PoseMode(population.poses))
    with ExitStack() as stack:
        for name, instead in RULES.get(job.rule, {}).items():
            stack.enter_context(patch(name, instead))
        begun = time.process_time()
        feature_map = map_sweeps(JointMapper(recording.rig, settings), sweeps)
        seconds = time.process_time() - begun
    return Mapped(numbers=numbers_of(feature_map), evaluation=evaluate(feature_map, recording.truth), seconds=seconds)


def numbers_of(feature_map: FeatureMap) -> list[Any]:
    """Return the geometry and the poses of a map."""
    return [
        [each.endpoints_xy.tolist() for each in feature_map.walls],
        [each.position_xy.tolist() for each in feature_map.corners],
        [[*each.center_xy.tolist(), each.radius] for each in feature_map.cylinders],
        feature_map.poses.tolist(),
    ]


def table(kind: str, maps: Mapping[str, Sequence[Mapped]]) -> Table:
    """Compare the maps without each rule with those of all rules."""
    complete = maps[ALL]
    rows = [row(rule, complete, without) for rule, without in maps.items() if rule != ALL]
    return Table(
        title=f"{len(complete)} {kind}", columns=("without", "maps changed", "worse", "better"), rows=tuple(rows)
    )


def row(rule: str, complete: Sequence[Mapped], without: Sequence[Mapped]) -> tuple[str, ...]:
    """Return how many maps change without a rule, and which measures become worse or better."""
    changed = sum(one.numbers != other.numbers for one, other in zip(complete, without, strict=True))
    worse, better = (differences(*pair) for pair in ((complete, without), (without, complete)))
    return rule, str(changed), ", ".join(worse) or "-", ", ".join(better) or "-"


def differences(before: Sequence[Mapped], after: Sequence[Mapped]) -> list[str]:
    """Return the measures that are worse after than before, beyond the tolerances."""
    scores = (
        Scores(evaluations=[each.evaluation for each in maps], seconds=sum(each.seconds for each in maps))
        for maps in (before, after)
    )
    return compare("", *scores)[1]


if __name__ == "__main__":
    main()
