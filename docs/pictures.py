"""Makes the pictures of the documents anew: python docs/pictures.py."""

from collections.abc import Callable
from pathlib import Path

from echoplan.io import builtin_rig, builtin_route, builtin_world, write_bytes
from echoplan.methods.mdp_fuzzy import MdpFuzzyMapper
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.viewer import EchoListener, Plan, paper_pictures, sweep_stages

PICTURES = Path(__file__).parent / "pictures"


def main() -> None:
    """Draw all of them."""
    for draw in DRAWINGS:
        draw()


def paper_room() -> None:
    """Draw the paper's room as ``echoplan demo`` does: the figures that docs/paper.md and the README show."""
    simulation = Simulation(
        world=builtin_world("paper-room"),
        rig=builtin_rig("rotary-array"),
        route=builtin_route("paper-room"),
        settings=SimulationSettings(dropout=0.02, stray=0.02),
    )
    mapper, listener = MdpFuzzyMapper(simulation.rig), EchoListener(simulation.rig)
    sweeps = list(listener.listen(simulation))
    for sweep in sweeps:
        mapper.add(sweep)
    plan = Plan(feature_map=mapper.result(), truth=simulation.truth, echoes_xy=listener.points_xy)
    for picture in paper_pictures([sweep_stages(mapper, sweep) for sweep in sweeps], plan):
        write_bytes(PICTURES / f"{picture.name}.png", picture.png)


DRAWINGS: tuple[Callable[[], None], ...] = (paper_room,)

if __name__ == "__main__":
    main()
