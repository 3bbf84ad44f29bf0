"""A device in MicroPython's unix port: the programs of the boards with simulated pins, as a TCP server.

    micropython firmware/micropython/simulation/device.py PORT FLIGHTS

It prints "ready" when it listens.  Each line of the file FLIGHTS is a pulse of the servo [us] and the time of flight of
each sensor there [us]: 0 for no echo, -1 for a pin stuck high.

The time that a ping takes is simulated, so that a busy computer does not change the times of flight.
"""

import sys
import time as real_time

import machine as real_machine

PORT, FLIGHTS = sys.argv[1:3]
HERE = __file__.rsplit("/", 1)[0] if "/" in __file__ else "."
sys.path[:0] = [HERE + "/..", HERE + "/../../../src/echoplan/hardware"]
# An HC-SR04 raises its echo pin so long after the trigger [us], and lowers it after so long if no echo comes.
DELAY, NO_ECHO = 460, 38000
# What a turn of the loop that watches the pins takes [us].
TURN = 10


class Time:
    """The module time, with a clock that a ping stops and turns."""

    ticks_diff = real_time.ticks_diff

    def __init__(self):
        self.skipped = 0
        self.stopped = None

    def ticks_us(self):
        if self.stopped is None:
            return real_time.ticks_us() + self.skipped
        self.stopped += TURN
        return self.stopped

    def sleep_us(self, duration):
        if self.stopped is not None:
            self.stopped += duration

    def stop(self):
        self.stopped = self.ticks_us()

    def go_on(self):
        if self.stopped is not None:
            self.skipped = self.stopped - real_time.ticks_us()
            self.stopped = None


class Machine:
    """The module machine."""

    def time_pulse_us(self, pin, level, timeout):
        time.stopped += DELAY + timeout
        if not pin.flight:
            return -1
        time.stopped -= timeout - pin.flight
        return pin.flight


class Servo:
    """The signal of a servo."""

    pulse_us = 1500

    def duty_ns(self, nanoseconds):
        self.pulse_us = nanoseconds // 1000


class Trigger(real_machine.PinBase):
    """The pin that starts a ping."""

    def __init__(self):
        self.level = 0
        self.fell = None

    def value(self, level=None):
        if level is None:
            return self.level
        if self.level and not level:
            self.fell = time.stopped
        elif level:
            time.stop()
        self.level = level


class Echo(real_machine.PinBase):
    """The pin that is high while the sound is on its way."""

    def __init__(self, trigger, flights):
        self.trigger, self.flights = trigger, flights
        self.pulse = 0

    @property
    def flight(self):
        # What is on its way does not depend on where the servo turns next.
        if time.stopped is not None:
            self.pulse = self.flights[servo.pulse_us]
        return self.flights[servo.pulse_us]

    def value(self, level=None):
        if self.flight < 0 or self.trigger.fell is None:
            return int(self.flight < 0)
        now = time.ticks_us() if time.stopped is None else time.stopped
        return int(0 <= now - self.trigger.fell - DELAY < (self.pulse or NO_ECHO))


time, servo = Time(), Servo()
sys.modules["time"], sys.modules["machine"] = time, Machine()

from head import Head  # noqa: E402 - found by the path above
from pins import PinBoard  # noqa: E402
from ports import TcpPort, serve  # noqa: E402


class Port(TcpPort):
    """A port that lets the clock go on between pings."""

    def read(self):
        time.go_on()
        return super().read()


table = [[int(text) for text in line.split()] for line in open(FLIGHTS)]
sensors = []
for number in range(1, len(table[0])):
    trigger = Trigger()
    sensors.append((trigger, Echo(trigger, {row[0]: row[number] for row in table})))
board = PinBoard(name="unix", sensors=sensors, servo=servo)
ports = [Port(int(PORT), "127.0.0.1")]
print("ready")
serve(Head(board), ports)
