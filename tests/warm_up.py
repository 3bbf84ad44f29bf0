"""Compile once, in one process, what many tests need: two workers would each compile it for a minute."""

import echoplan
from echoplan.model import Conventions


def main() -> None:
    """Map a room, and the same from a servo that turns the wrong way, for which the assessment tries other causes."""
    recording = echoplan.simulate("square", seed=1)
    echoplan.map(recording)
    mirrored = tuple(Conventions(servo_sign=-1).undo(sweep) for sweep in recording)
    echoplan.map(echoplan.Recording(name="mirrored", rig=recording.rig, sweeps=mirrored))


if __name__ == "__main__":
    main()
