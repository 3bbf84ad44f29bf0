"""Diagnosis: whether a map can be trusted, and if not, what is wrong with the recording."""

from echoplan.diagnosis.assessment import Measures, assess, examine, verdict_of
from echoplan.diagnosis.causes import Cause, Remedy, find_remedies
from echoplan.diagnosis.findings import faults_in_words
from echoplan.diagnosis.localisation import assess_localisation
from echoplan.diagnosis.stations import Misplaced, misplaced_stations

__all__ = [
    "Cause",
    "Measures",
    "Misplaced",
    "Remedy",
    "assess",
    "assess_localisation",
    "examine",
    "faults_in_words",
    "find_remedies",
    "misplaced_stations",
    "verdict_of",
]
