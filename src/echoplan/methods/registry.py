"""The methods by name: what turns sweeps into a map, all of equal rank."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module

from pydantic import BaseModel

from echoplan.errors import UnknownNameError
from echoplan.methods.local import LocalMapper
from echoplan.model import Rig

__all__ = ["METHODS", "Method", "find_method"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """A mapper by name, imported when it is needed.

    Parameters
    ----------
    name : str
        What to call it on the command line.
    summary : str
        What it does, in one line.
    mapper, settings : str
        Names of its mapper and of its settings in its module.
    module : str, optional
        Module that defines them; by default the module of ``echoplan.classical`` named like the method.
    """

    name: str
    summary: str
    mapper: str
    settings: str
    module: str = ""

    @property
    def settings_type(self) -> type[BaseModel]:
        """The model of its settings."""
        found: type[BaseModel] = getattr(self._module(), self.settings)
        return found

    def build(self, rig: Rig, settings: BaseModel | None = None) -> LocalMapper:
        """Make a mapper.

        Parameters
        ----------
        rig : Rig
            What made the sweeps.
        settings : BaseModel, optional
            Settings of ``settings_type``.

        Returns
        -------
        LocalMapper
            Ready for the first sweep; it checks sweeps and maps in a frame near the first station.
        """
        return LocalMapper(getattr(self._module(), self.mapper)(rig, settings or self.settings_type()), rig)

    def _module(self) -> object:
        return import_module(self.module or f"echoplan.classical.{self.name.replace('-', '_')}")


METHODS: Mapping[str, Method] = {
    method.name: method
    for method in (
        Method(
            name="joint",
            summary="all stations at once: competing reflectors under a physical model of the sonar",
            mapper="JointMapper",
            settings="JointSettings",
            module="echoplan.joint.mapper",
        ),
        Method(
            name="mdp-fuzzy",
            summary="the 2018 paper: MDP compensation, polynomial minimum, fuzzy classes",
            mapper="MdpFuzzyMapper",
            settings="MdpFuzzySettings",
        ),
        Method(
            name="rcd",
            summary="regions of constant depth, the conventional approach of the paper's Section 3.1",
            mapper="RcdMapper",
            settings="RcdMapperSettings",
        ),
        Method(
            name="point-plot",
            summary="the plain plot of points, each echo on the axis of its beam: what everyone draws first",
            mapper="PointPlotMapper",
            settings="PointPlotSettings",
        ),
        Method(
            name="atm",
            summary="arc-transversal median: the median of the crossings along each arc",
            mapper="AtmMapper",
            settings="AtmSettings",
        ),
        Method(
            name="tbf",
            summary="triangulation-based fusion: points on which several sweeps agree",
            mapper="TbfMapper",
            settings="TbfSettings",
        ),
        Method(
            name="arc-carving",
            summary="arc carving: newer echoes cut what they show to be free out of older arcs",
            mapper="ArcCarvingMapper",
            settings="ArcCarvingSettings",
        ),
        Method(
            name="directional-maximum",
            summary="directional maximum: arcs thinned to their densest cells along many directions",
            mapper="DirectionalMaximumMapper",
            settings="DirectionalMaximumSettings",
        ),
        Method(
            name="hough",
            summary="Hough votes of echoes for the lines and points that they may come from",
            mapper="HoughMapper",
            settings="HoughSettings",
        ),
        Method(
            name="arc-hough-tbf",
            summary="tangents of arcs fused with Hough lines of triangulated points",
            mapper="ArcHoughTbfMapper",
            settings="ArcHoughTbfSettings",
        ),
        Method(
            name="iepf-kalman",
            summary="segments of consecutive echoes by iterative end-point fit and Kalman filter",
            mapper="IepfKalmanMapper",
            settings="IepfKalmanSettings",
        ),
        Method(
            name="gmm",
            summary="incremental Gaussian mixture: each component is a patch of a surface",
            mapper="GmmMapper",
            settings="GmmSettings",
        ),
        Method(
            name="salient-ekf",
            summary="salient features and an extended Kalman filter that corrects the poses",
            mapper="SalientEkfMapper",
            settings="SalientEkfSettings",
        ),
        Method(
            name="grid-elfes",
            summary="certainty grid of Moravec and Elfes: empty and occupied apart, cancelled and normalised",
            mapper="grid_elfes_mapper",
            settings="GridElfesSettings",
        ),
        Method(
            name="grid-bayes",
            summary="Bayesian occupancy grid: log odds of an inverse sensor model",
            mapper="grid_bayes_mapper",
            settings="GridBayesSettings",
        ),
        Method(
            name="grid-muriel",
            summary="MURIEL grid: evidence of each place counts once, sound may be thrown away",
            mapper="grid_muriel_mapper",
            settings="GridMurielSettings",
        ),
        Method(
            name="grid-cemal",
            summary="maximum-likelihood grid: readings that contradict shorter ones are discarded",
            mapper="grid_cemal_mapper",
            settings="GridCemalSettings",
        ),
        Method(
            name="grid-range-layer",
            summary="what Nav2's range_sensor_layer would map, with its defects",
            mapper="grid_range_layer_mapper",
            settings="GridRangeLayerSettings",
        ),
        Method(
            name="topological",
            summary="places and the passages between them, from free space; walls as mdp-fuzzy",
            mapper="TopologicalMapper",
            settings="TopologicalSettings",
        ),
    )
}


def find_method(name: str) -> Method:
    """Find a method by its name.

    Parameters
    ----------
    name : str
        As on the command line.

    Returns
    -------
    Method
        The method.

    Raises
    ------
    UnknownNameError
        If there is none of that name.

    Examples
    --------
    >>> find_method("rcd").name
    'rcd'
    """
    try:
        return METHODS[name]
    except KeyError:
        raise UnknownNameError("method", name, known=METHODS) from None
