"""Compile once, in one process, what many tests need: two workers would each compile it for a minute."""

from itertools import islice

import echoplan
from echoplan.model import Conventions


def main() -> None:
    """Map a room, and another one from a servo that turns the wrong way, for which more of the code runs."""
    echoplan.map(echoplan.simulate("square", seed=1))
    # A recording that is not understood takes long: one sensor and three stations are enough.
    recording = echoplan.simulate("square", rig="hc-sr04-servo", seed=1)
    mirrored = tuple(Conventions(servo_sign=-1).undo(sweep) for sweep in islice(recording, 3))
    echoplan.map(echoplan.Recording(name="mirrored", rig=recording.rig, sweeps=mirrored))


if __name__ == "__main__":
    main()
