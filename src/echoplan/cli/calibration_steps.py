"""The steps of ``echoplan calibrate``: what to do, and what was found."""

import math
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from echoplan.acoustics import Air, piston_ka, typical_transducer
from echoplan.cli.sweep_progress import SweepProgress
from echoplan.cli.terminal import put
from echoplan.errors import InputError
from echoplan.geometry import wrap
from echoplan.hardware import Device
from echoplan.hardware.calibration import Observations, assigned, calibrate, front_of
from echoplan.hardware.hands import covered_sensors, hand_side
from echoplan.hardware.walls import Arc, Estimate, find_arcs
from echoplan.model import Conventions, Firing, Rig, Sensor, Servo, Sweep

__all__ = ["Guide", "observe"]

Found = TypeVar("Found")

# How often a step may fail.
_ATTEMPTS = 3
# A servo that hardly turns, while a hand is at a sensor [rad].
_STILL = Servo(start=0.0, stop=math.radians(2.0), step=math.radians(1.0))
# Coarser steps of the servo show the edges of an arc too roughly [rad].
_COARSEST = math.radians(2.0)
# Time after which the echoes of a room have died away [s].
_GUARD = 0.03
# Of thermometers and people [degrees Celsius]; and of a room of which nothing is known.
_THERMOMETER, _ROOM = 1.0, Estimate(value=20.0, sigma=5.0)
# What a reading of the wall may differ from the tape [m], and a corner's walls from the wall's distance, as a share.
_GATE, _CORNER_GATE = 0.12, 0.25
# An arc of a wall has at least so many pings in two sweeps, and ranges that fit the model this well [m].
_FEWEST, _FLATTEST = 12, 0.008
# The beam of a sensor is at most so many times narrower or wider than its rig states.
_BEAM = 2.5
# The sensor faces the wall to this [rad], and walls of a corner are so far apart [rad].
_FACING, _APART = math.radians(30.0), (math.radians(60.0), math.radians(135.0))
_NAMES = {0: "front", 90: "left", 180: "back", -90: "right"}
_TURNS = {90: "90 degrees to the right", 180: "half a turn", -90: "90 degrees to the left"}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Problem:
    """Why a step has to be repeated, as a clause, and what to do."""

    text: str
    remedy: str


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Guide:
    """Asks a person for one step after the other.

    Parameters
    ----------
    device : Device
        The device.
    progress : SweepProgress
        Shows what the device does.
    """

    device: Device
    progress: SweepProgress

    def ask(self, question: str) -> str:
        """Ask, and return the answer.

        Raises ``InputError`` if no answer comes any more.
        """
        put(question)
        if sys.stdin.isatty():
            sys.stderr.write("> ")
            sys.stderr.flush()
        sys.stdout.flush()
        line = sys.stdin.readline()
        if not line:
            remedy = "answer each step with Enter, a number, or s to skip it"
            raise InputError("standard input", "the answers ended before the calibration", remedy=remedy)
        return line.strip()

    def sweep(self, rig: Rig) -> list[Sweep]:
        """Make two sweeps, to and fro, in steps of 2 degrees at most; the sensors fire one after the other.

        If they fire together, they receive each other's bursts, and the arcs of walls are up to 2 degrees wider.
        """
        period = max(rig.firing.period if rig.firing else 0.0, _GUARD)
        groups = tuple((each,) for each in rig.sensor_ids.tolist())
        servo = rig.servo and replace(rig.servo, step=min(rig.servo.step, _COARSEST))
        alone = replace(rig, firing=Firing(period=period, groups=groups), servo=servo)
        self.progress.begin("sweeping", rig, sweeps=2)
        sweeps = list(self.device.sweeps(2, rig=alone))
        self.progress.end()
        return sweeps

    def step(self, question: str, measure: Callable[[str], Found | _Problem]) -> Found | None:
        """Return what a step found, None if it is skipped; repeat it if there is a problem.

        Raises ``InputError`` after the last attempt.
        """
        problems: list[_Problem] = []
        while len(problems) < _ATTEMPTS:
            if problems:
                put(f"  Problem: {problems[-1].text}; {problems[-1].remedy}.")
            answer = self.ask(question)
            if answer.lower() in ("s", "skip"):
                return None
            found = measure(answer)
            if not isinstance(found, _Problem):
                return found
            problems.append(found)
        problem = f"{problems[-1].text} ({_ATTEMPTS} attempts)"
        raise InputError(self.device.address, problem, remedy=f"{problems[-1].remedy}, or skip the step with s")


def observe(guide: Guide, rig: Rig, conventions: Conventions) -> Observations | None:
    """Go through all steps, and return what they found; None if all were skipped.

    Raises ``InputError`` if a step fails repeatedly, or the answers end.
    """
    put("Press Enter after each step; s and Enter skips it.")
    put()
    placed = _identify(guide, rig)
    rig = placed or rig
    sign = _find_sign(guide, rig)
    air = _find_temperature(guide, rig)
    seen = Observations(rig=rig, conventions=conventions, air=air or _ROOM, servo_sign=sign)
    seen = _see_wall(guide, seen)
    if seen.walls:
        for sensor in rig.sensors:
            seen = seen if sensor.sensor_id in seen.walls else _see_wall_again(guide, seen, sensor)
        seen = _see_corner(guide, seen)
    else:
        put("Without a wall, beam, offsets and gain stay as they are.")
    return None if placed is None and sign is None and not seen.walls else seen


def _identify(guide: Guide, rig: Rig) -> Rig | None:
    """Find out which sensor is which; None if that is skipped, or there is one only."""
    if len(rig.sensors) == 1:
        return None
    still = replace(rig, servo=_STILL)
    left = set(rig.sensor_ids.tolist())
    order: list[int] = []
    for sensor in rig.sensors[:-1]:
        name = _name(sensor, rig)

        def measure(_: str, name: str = name) -> int | _Problem:
            """Return the number of the covered sensor."""
            covered = covered_sensors(guide.sweep(still))
            remedy = f"cover only the {name} sensor, with a flat hand about 5 cm from it"
            if not covered:
                return _Problem(text="no sensor is covered", remedy=remedy)
            if len(covered) > 1:
                return _Problem(text=f"sensors {', '.join(map(str, covered))} all read short", remedy=remedy)
            if covered[0] not in left:
                return _Problem(text=f"sensor {covered[0]} was covered before", remedy=remedy)
            return covered[0]

        found = guide.step(f"Hold a flat hand about 5 cm from the {name} sensor, and press Enter.", measure)
        if found is None:
            put("  The sensors stay as the rig has them.")
            return None
        put(f"  The {name} sensor is number {found}.")
        order.append(found)
        left.remove(found)
    put(f"  So the {_name(rig.sensors[-1], rig)} sensor is number {min(left)}.")
    return assigned(rig, [*order, *left])


def _find_sign(guide: Guide, rig: Rig) -> int | None:
    """Find out which way the servo turns: 1 counter-clockwise, -1 clockwise."""
    remedy = "clear half a metre around the robot, and hold the hand still, facing it"

    def measure(_: str) -> int | _Problem:
        """Return the sign of the servo by the side on which the hand is seen."""
        side = hand_side(guide.sweep(rig), sensor_id=front_of(rig).sensor_id)
        if math.isnan(side):
            return _Problem(text="no hand was seen within 50 cm", remedy=remedy)
        if 0.2 < side < 0.8:
            return _Problem(text="there is something within 50 cm on both sides", remedy=remedy)
        return 1 if side > 0.5 else -1

    question = "Hold a hand 30 cm from the robot, halfway between ahead and left, and press Enter."
    sign = guide.step(question, measure)
    if sign is not None:
        words = "counter-clockwise, as it should" if sign == 1 else "clockwise: servo_sign is -1"
        put(f"  The servo turns {words}.")
    return sign


def _find_temperature(guide: Guide, rig: Rig) -> Estimate | None:
    """Return the temperature of the air [degrees Celsius]: of the thermometer of the device, or as answered."""
    if "air" in guide.device.capabilities:
        sweeps = guide.sweep(replace(rig, servo=_STILL))
        if not math.isnan(sweeps[-1].temperature):
            put(f"The thermometer of the device reads {sweeps[-1].temperature:.1f} deg C.")
            return Estimate(value=sweeps[-1].temperature, sigma=_THERMOMETER)

    def measure(answer: str) -> Estimate | _Problem:
        """Return the temperature that was typed."""
        value = _number(answer, unit="c")
        if not -30.0 <= value <= 60.0:
            return _Problem(text=f"{answer!r} is no temperature", remedy="type degrees Celsius, such as 21")
        return Estimate(value=value, sigma=_THERMOMETER)

    found = guide.step("What is the temperature of the air in degrees Celsius?", measure)
    if found is None:
        put("  The air is taken to have 20 ± 5 deg C.")
    return found


def _see_wall(guide: Guide, seen: Observations) -> Observations:
    """Let the front sensor look at a flat wall at a distance that is measured by tape."""
    front = front_of(seen.rig)
    farthest = 90.0 * front.max_range

    def measure(answer: str) -> Observations | _Problem:
        """Return the observations with the wall at the distance that was typed."""
        distance = _number(answer, unit="cm")
        if not 30.0 <= distance <= farthest:
            remedy = f"type centimetres from 30 to {farthest:.0f}, such as {_best_distance(seen.rig):.0f}"
            return _Problem(text=f"{answer!r} is no distance", remedy=remedy)
        return _wall_seen(guide, replace(seen, distance=0.01 * distance), front)

    found = guide.step(
        "Turn the robot so that it faces a flat wall squarely, with 1 m of wall to either side. What is the distance "
        f"from the axis of the servo to the wall in cm? About {_best_distance(seen.rig):.0f} is best.",
        measure,
    )
    return found or seen


def _best_distance(rig: Rig) -> float:
    """Return the distance from a wall [cm] at which its arc fits into a sweep."""
    is_wide = rig.servo is not None and min(-rig.servo.start, rig.servo.stop) > math.radians(60.0)
    return 100.0 if is_wide else 50.0 * front_of(rig).max_range


def _see_wall_again(guide: Guide, seen: Observations, sensor: Sensor) -> Observations:
    """Let another sensor look at the same wall."""
    name, angle = _name(sensor, seen.rig), _mounting(sensor, seen.rig)
    turn = _TURNS.get(angle, f"by {abs(angle)} degrees to the {'right' if angle > 0 else 'left'}")
    question = (
        f"From facing the wall, turn the robot on the spot {turn}: its {name} sensor faces the wall, at the same "
        "distance. Press Enter."
    )
    found = guide.step(question, lambda _: _wall_seen(guide, seen, sensor))
    if found is None:
        put("  It is taken to be like the front sensor.")
    return found or seen


def _wall_seen(guide: Guide, seen: Observations, sensor: Sensor) -> Observations | _Problem:
    """Sweep in front of the wall, and add what the sensor saw of it."""
    sweeps = guide.sweep(seen.rig)
    depth = seen.distance - math.hypot(sensor.x, sensor.y)
    arcs = find_arcs(sweeps, sensor_id=sensor.sensor_id, depth=depth, gate=_GATE, scale=_scale(seen))
    if not arcs or len(arcs[0].angles) < _FEWEST:
        remedy = "check the tape, face the wall squarely, and remove what stands in front of it"
        return _Problem(text=f"no wall was seen at {100 * seen.distance:.0f} cm", remedy=remedy)
    view = calibrate(replace(seen, walls={sensor.sensor_id: arcs[0]})).views[0]
    center, fit = view.fit.centers[0].value, view.fit
    expected = piston_ka(seen.rig.transducer or typical_transducer(front_of(seen.rig)), Air())
    if fit.rms > _FLATTEST or not 1 / _BEAM < fit.ka.value / expected < _BEAM:
        problem = f"the wall is not flat, or too short: ranges differ from the model by {1000 * fit.rms:.0f} mm"
        return _Problem(text=problem, remedy="find at least 2 m of smooth wall without furniture")
    sign = seen.servo_sign or seen.conventions.servo_sign
    if abs(sign * center) > _FACING:
        return _Problem(
            text=f"the wall is seen at a servo angle of {math.degrees(center):.0f} degrees",
            remedy=f"turn the robot so that its {_name(sensor, seen.rig)} sensor faces the wall",
        )
    width = math.degrees(float(np.ptp(arcs[0].angles)))
    put(
        f"  Sensor {sensor.sensor_id} sees the wall over {width:.0f} degrees of the servo, with its middle at "
        f"{math.degrees(center):.1f}, and reads {1000 * (fit.depths[0].value - seen.distance):+.0f} mm."
    )
    return replace(seen, walls={**seen.walls, sensor.sensor_id: arcs[0]})


def _see_corner(guide: Guide, seen: Observations) -> Observations:
    """Let the front sensor look at two walls at a right angle."""
    front = front_of(seen.rig)
    # At equal distances the echoes of the two walls overlap, and their arcs seem wider.
    left_cm, right_cm = 100 * seen.distance - 15.0, 100 * seen.distance

    def measure(_: str) -> tuple[Arc, ...] | _Problem:
        """Return the arcs of the right and the left wall of the corner."""
        sweeps = guide.sweep(seen.rig)
        depth = seen.distance - math.hypot(front.x, front.y)
        gate = _CORNER_GATE * seen.distance
        arcs = find_arcs(sweeps, sensor_id=front.sensor_id, depth=depth, gate=gate, scale=_scale(seen))[:2]
        if len(arcs) < 2 or len(arcs[1].angles) < _FEWEST:
            remedy = (
                f"face the corner itself, {left_cm:.0f} and {right_cm:.0f} cm from its walls, with nothing in between"
            )
            return _Problem(text=f"{len(arcs)} of the two walls of a corner seen", remedy=remedy)
        right, left = sorted(arcs, key=lambda arc: float(arc.angles.mean()))
        walls = {front.sensor_id: seen.walls[front.sensor_id]}
        separation = calibrate(replace(seen, walls=walls, corner=(right, left))).views[-1].fit.separation.value
        if not _APART[0] < separation < _APART[1]:
            problem = f"the walls seem {math.degrees(separation):.0f} degrees apart"
            return _Problem(text=problem, remedy="find a right-angled corner without furniture")
        put(f"  The servo records {math.degrees(separation):.1f} degrees from wall to wall, where 90 are right.")
        return right, left

    question = (
        "Place the robot so that it faces a right-angled corner of the room: the axis of the servo about "
        f"{left_cm:.0f} cm from the left wall and {right_cm:.0f} cm from the right wall. Press Enter."
    )
    found = guide.step(question, measure)
    if found is None:
        put("  The gain of the servo stays as it is.")
    return replace(seen, corner=found or ())


def _scale(seen: Observations) -> float:
    """Return the depth for each metre that is read: the air differs from that which the modules assume."""
    return Air(temperature=seen.air.value).speed_of_sound / (seen.rig.speed_of_sound or Air().speed_of_sound)


def _number(text: str, *, unit: str) -> float:
    """Read a number, with or without its unit; nan if it is none."""
    match = re.fullmatch(rf"([+-]?\d+(?:[.,]\d*)?)\s*(?:°?\s*{unit})?", text.strip().lower())
    return float(match[1].replace(",", ".")) if match else math.nan


def _mounting(sensor: Sensor, rig: Rig) -> int:
    """Return where a sensor points when the servo is at angle 0 [degrees], in whole degrees, above -180."""
    angle = round(math.degrees(float(wrap(sensor.yaw + rig.base_from_turret[2]))))
    return 180 if angle == -180 else angle


def _name(sensor: Sensor, rig: Rig) -> str:
    angle = _mounting(sensor, rig)
    return _NAMES.get(angle, f"{abs(angle)} degrees {'left' if angle > 0 else 'right'}")
