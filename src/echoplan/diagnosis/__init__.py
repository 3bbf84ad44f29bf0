"""Diagnosis: whether a map can be trusted, and if not, what is wrong with the recording."""

from echoplan.diagnosis.assessment import FEWEST_PLACES, Measures, assess, examine, verdict_of
from echoplan.diagnosis.causes import Cause, Remedy, find_remedies
from echoplan.diagnosis.stations import Misplaced, misplaced_stations

__all__ = [
    "FEWEST_PLACES",
    "Cause",
    "Measures",
    "Misplaced",
    "Remedy",
    "assess",
    "examine",
    "find_remedies",
    "misplaced_stations",
    "verdict_of",
]
