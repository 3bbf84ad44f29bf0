"""All stations at once: rival reflectors, judged by what a sonar should hear of them, and one adjustment of all.

A wall is a line that touches the range circles of its stations, a corner or an edge a point on them, a cylinder one
that touches them (Leonard and Durrant-Whyte 1992).  A physical model of loudness, beam, masking and range walk says
which of these explains the pings, including those that are missing.
"""

import math
from dataclasses import replace

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics import typical_transducer
from echoplan.acoustics.expectation import EchoModel
from echoplan.classification.hypotheses import Explanation, Hypothesis
from echoplan.extraction.arcs import ArcSettings, find_arcs
from echoplan.mapping.adjustment import Adjusted, AdjustmentSettings, Beliefs, Features, adjust
from echoplan.mapping.faces import FaceSettings, corner_echoes, find_faces
from echoplan.mapping.loudness import fit_loudness
from echoplan.mapping.paths import trace_paths
from echoplan.mapping.rivals import class_probabilities
from echoplan.mapping.search import Search, SearchSettings
from echoplan.mapping.survey import Survey, SurveySettings
from echoplan.mapping.vertices import VertexSettings, find_vertices
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.preprocessing.health import HealthSettings, healthy
from echoplan.preprocessing.soundings import Soundings, chosen_soundings, join_soundings, soundings_of

__all__ = ["JointMapper", "JointSettings"]


class JointSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of all stages."""

    health: HealthSettings = Field(default_factory=HealthSettings)
    arcs: ArcSettings = Field(default_factory=ArcSettings)
    search: SearchSettings = Field(default_factory=SearchSettings)
    adjustment: AdjustmentSettings = Field(default_factory=AdjustmentSettings)
    faces: FaceSettings = Field(default_factory=FaceSettings)
    vertices: VertexSettings = Field(default_factory=VertexSettings)
    survey: SurveySettings = Field(default_factory=SurveySettings)
    first_noise: float = Field(default=0.008, gt=0.0, description="of readings before anything is known [m]")
    least_noise: float = Field(default=0.0025, gt=0.0, description="of the best sensors [m]")
    greatest_noise: float = Field(default=0.05, gt=0.0, description="of readings that still make a map [m]")


class JointMapper:
    """Maps all stations at once.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : JointSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: JointSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or JointSettings()
        self._sweeps: list[Sweep] = []
        self._soundings: list[Soundings] = []

    def add(self, sweep: Sweep) -> None:
        """Take one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._sweeps.append(sweep)
        self._soundings.append(soundings_of(sweep, self.rig))

    def result(self) -> FeatureMap:
        """Explain everything that was heard so far.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        run = _Run(self.rig, self._soundings, self.settings)
        features, adjusted = run.explain()
        survey = run.survey(features, adjusted)
        return FeatureMap(
            method="joint",
            parameters=self.settings.model_dump(mode="json"),
            walls=survey.walls(),
            corners=survey.corners(),
            cylinders=survey.cylinders(),
            sweeps=np.array([sweep.index for sweep in self._sweeps], dtype=np.int64),
            poses=np.array([sweep.station for sweep in self._sweeps]).reshape(-1, 3),
        )


class _Run:
    """One explanation of everything, from the arcs to the adjusted features."""

    def __init__(self, rig: Rig, parts: list[Soundings], settings: JointSettings) -> None:
        self.settings = settings
        self.resolution = max(sensor.resolution for sensor in rig.sensors)
        self.half_aperture = float(np.median([sensor.half_aperture for sensor in rig.sensors]))
        everything = join_soundings(parts)
        self.soundings = chosen_soundings(everything, healthy(everything, settings.health))
        self.arcs = find_arcs(self.soundings, resolution=self.resolution, settings=settings.arcs)
        self.prior = EchoModel.of(rig.transducer or typical_transducer(rig.sensors[0]))
        self.has_servo = bool(np.any(self.soundings.rates))

    def explain(self) -> tuple[list[Hypothesis], Adjusted]:
        first = max(self.settings.first_noise, 0.9 * self.resolution)
        features = self._search(self.prior, first).run()
        adjusted = self._adjust(features, self.prior, self.settings.first_noise)
        features = self._judged(features, adjusted, self.settings.first_noise)
        model = fit_loudness(self.soundings, adjusted.model, features, believed=self.prior.figure_of_merit)
        adjusted = self._adjust(features, model, 0.75 * self.settings.first_noise)
        noise = self._noise(adjusted)
        features = self._search(adjusted.model, noise).run(_moved(features, adjusted))
        adjusted = self._adjust(features, adjusted.model, noise)
        features = self._search(adjusted.model, noise).settled(_moved(features, adjusted))
        return features, self._adjust(features, adjusted.model, noise)

    def survey(self, features: list[Hypothesis], adjusted: Adjusted) -> Survey:
        noise = self._noise(adjusted)
        explanation = Explanation(self.soundings, adjusted.model.tabulated(), noise)
        search = self._search(adjusted.model, noise)
        features = self._judged(features, adjusted, noise)
        paths = trace_paths(explanation, features, step=search.step)
        echoes = corner_echoes(explanation, features)
        faces = find_faces(features, paths, echoes, step=search.step, settings=self.settings.faces)
        cost = self.settings.search.radius_cost
        return Survey(
            features=features,
            adjusted=adjusted,
            faces=faces,
            vertices=find_vertices(faces, echoes, self.settings.vertices),
            probabilities=class_probabilities(explanation, features, radius_cost=cost),
            settings=self.settings.survey,
        )

    def _search(self, model: EchoModel, noise: float) -> Search:
        explanation = Explanation(self.soundings, model.tabulated(), noise)
        return Search(explanation, self.arcs, half_aperture=self.half_aperture, settings=self.settings.search)

    def _adjust(self, features: list[Hypothesis], model: EchoModel, noise: float) -> Adjusted:
        beliefs = Beliefs(
            noise=noise,
            offset_sigma=self.resolution / math.sqrt(12.0),
            walk_gain=self.prior.walk_gain,
            has_servo=self.has_servo,
        )
        return adjust(
            self.soundings, _as_arrays(features, len(self.soundings.centers)), model, beliefs, self.settings.adjustment
        )

    def _judged(self, features: list[Hypothesis], adjusted: Adjusted, noise: float) -> list[Hypothesis]:
        return self._search(adjusted.model, noise).judged(_moved(features, adjusted))

    def _noise(self, adjusted: Adjusted) -> float:
        scatter = 1.25 * adjusted.scatter
        if math.isnan(scatter):
            return self.settings.first_noise
        return min(max(scatter, self.settings.least_noise), self.settings.greatest_noise)


def _moved(features: list[Hypothesis], adjusted: Adjusted) -> list[Hypothesis]:
    return [replace(each, reflector=row) for each, row in zip(features, adjusted.reflectors, strict=True)]


def _as_arrays(features: list[Hypothesis], stations: int) -> Features:
    return Features(
        reflectors=np.array([each.reflector for each in features]).reshape(-1, 4),
        extents=np.array([each.extent for each in features]).reshape(-1, 2),
        heard=np.array([each.gains > 0.0 for each in features]).reshape(-1, stations),
    )
