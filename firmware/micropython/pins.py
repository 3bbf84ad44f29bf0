"""The pins of a board: HC-SR04 or the like, a servo, a thermometer and wheel encoders."""

import time

import machine
import micropython
from head import Board

# A trigger pulse [us], and how soon after it the echo pin must rise [us].
TRIGGER, RISE = 10, 5000
# An HC-SR04 that detects no echo keeps its pin high for 38 ms, some kinds for 200 ms, and ignores triggers [us].
RECOVERY = 200000


@micropython.native
def time_pulses(echoes, started, listen):
    """Return when each pin rose and fell [us] after the start; -1 where it did not."""
    count = len(echoes)
    rises, falls = [-1] * count, [-1] * count
    waiting = count
    now = 0
    while waiting > 0 and now <= listen + RISE:
        now = time.ticks_diff(time.ticks_us(), started)
        for number in range(count):
            if falls[number] >= 0:
                continue
            level = echoes[number].value()
            if rises[number] < 0 and level:
                rises[number] = now
            elif (rises[number] < 0 and now > RISE) or (rises[number] >= 0 and not level):
                falls[number] = now
                waiting -= 1
    return rises, falls


class Encoder:
    """An incremental encoder: pin A counts, pin B gives the direction; without B every edge counts forward."""

    def __init__(self, a, b=None):
        self.count = 0
        self.a, self.b = a, b
        a.irq(self.step, machine.Pin.IRQ_RISING)

    def step(self, _):
        """Count an edge."""
        self.count += 1 if self.b is None or self.b.value() else -1


class PinBoard(Board):
    """A board whose sensors are pairs of a trigger and an echo pin.

    The servo has a method ``duty_ns`` as ``machine.PWM``, the thermometer is a function that returns hundredths of a
    degree, and an encoder has a ``count``.
    """

    def __init__(self, *, name, sensors, servo=None, thermometer=None, encoders=(), tick=0, base=0):
        self.name = name
        self.pins = sensors
        self.sensors = len(sensors)
        self.pwm = servo
        self.thermometer = thermometer
        self.encoders = encoders
        self.tick, self.base = tick, base
        has = (("servo", servo), ("air", thermometer), ("wheels", encoders))
        self.capabilities = tuple(capability for capability, part in has if part)
        self.times = []
        # Sensors that detected no echo, and when.
        self.late = {}
        for trigger, _ in sensors:
            trigger.value(0)

    def servo(self, pulse_us):
        """Turn the servo."""
        self.pwm.duty_ns(1000 * pulse_us)

    def recovering(self):
        """Return the sensors whose echo pins are still high after a ping without echo."""
        now = time.ticks_us()
        for sensor, since in list(self.late.items()):
            if not self.pins[sensor][1].value() or time.ticks_diff(now, since) > RECOVERY:
                del self.late[sensor]
        return list(self.late)

    def fire(self, sensors, listen_us):
        """Trigger sensors at once, and listen until every echo has come."""
        free = [sensor for sensor in sensors if not self.pins[sensor][1].value()]
        for sensor in free:
            self.pins[sensor][0].value(1)
        time.sleep_us(TRIGGER)
        for sensor in free:
            self.pins[sensor][0].value(0)
        times = dict.fromkeys(sensors, -1)
        if len(free) == 1:
            # Good to a microsecond: the loop is in C.
            pulse = machine.time_pulse_us(self.pins[free[0]][1], 1, listen_us)
            times[free[0]] = -1 if pulse == -2 else max(pulse, 0)
        elif free:
            rises, falls = time_pulses([self.pins[sensor][1] for sensor in free], time.ticks_us(), listen_us)
            for sensor, rise, fall in zip(free, rises, falls):
                pulse = fall - rise
                times[sensor] = -1 if rise < 0 else pulse if 0 < pulse <= listen_us else 0
        self.late.update({sensor: time.ticks_us() for sensor in sensors if times[sensor] == 0})
        self.times = [times[sensor] for sensor in sensors]

    def flights(self):
        """Return the times of flight [us]."""
        return self.times

    def temperature(self):
        """Return the temperature of the air [0.01 deg C]."""
        return self.thermometer()

    def wheels(self):
        """Return the counts of the left and the right wheel."""
        return tuple(encoder.count for encoder in self.encoders)
