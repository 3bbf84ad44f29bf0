"""A square room in twenty lines: describe it, sound it, map it, look at it.  Run: python examples/square_room.py."""

from pathlib import Path

from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world, write_text
from echoplan.methods import find_method, map_sweeps
from echoplan.simulation import Simulation
from echoplan.viewer import Plan, plan_svg

room = Simulation(world=builtin_world("square"), rig=builtin_rig("rotary-array"), route=builtin_route("square"), seed=1)
found = map_sweeps(find_method("joint").build(room.rig), room)
for match in evaluate(found, room.truth).matches.walls.right:
    print(f"wall {match.truth + 1} is {1000 * match.distance:.1f} mm off")
write_text(Path("square-room.svg"), plan_svg(Plan(feature_map=found, truth=room.truth)))
print("drawn: square-room.svg")
