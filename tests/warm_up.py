"""Compile once, in one process, what many tests need: two workers would each compile it for a minute."""

from dataclasses import replace

import echoplan
from echoplan.model import Conventions


def main() -> None:
    """Map a room, the same from a servo that turns the wrong way, and the same as rays."""
    recording = echoplan.simulate("square", seed=1)
    echoplan.map(recording)
    sweeps = tuple(recording)
    mirrored = tuple(Conventions(servo_sign=-1).undo(sweep) for sweep in sweeps)
    for rig, read in ((recording.rig, mirrored), (replace(recording.rig, rays=True), sweeps)):
        echoplan.map(echoplan.Recording(name="warm-up", rig=rig, sweeps=read))


if __name__ == "__main__":
    main()
