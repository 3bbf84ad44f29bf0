"""The device's side of the protocol (docs/protocol.md): it runs unchanged in MicroPython and in CPython.

MicroPython has no typing, dataclasses or collections.abc, and no fixed order of dictionaries.  So this file imports
nothing but binascii, and annotations that need more are texts.  It has no clock and no input or output: time and
bytes are given to it.
"""

import binascii

# Type checkers take this for true, and MicroPython does without what it guards.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Generator, Iterator

__all__ = ["FIRMWARE", "SETTINGS", "Board", "Head", "line_of", "read_command"]

FIRMWARE = "0.1.0"
# Settings in the order of their report: name, smallest and largest value, default.
SETTINGS = (
    ("start", -9000, 9000, -4500),
    ("stop", -9000, 9000, 4500),
    ("step", 10, 4500, 100),
    ("zero", 500, 2500, 1500),
    ("gain", -1200, 1200, 1000),
    ("dwell", 5, 1000, 25),
    ("guard", 5, 250, 25),
    ("together", 0, 1, 0),
    ("settle", 0, 5000, 500),
    ("listen", 5, 60, 25),
    ("tick", 0, 9000, 0),
    ("base", 0, 9000, 0),
    ("window", 0, 255, 0),
)
_JOB, _SHORT, _VALUE, _LONG = (1, 65535), (0, 65535), (-9000, 9000), (0, 4294967295)
# Bounds of the fields of each command; a name has none.
_COMMANDS = {
    "hello": (),
    "config": (),
    "set": ((), _VALUE),
    "ping": (_SHORT,),
    "sweep": (_JOB, _SHORT),
    "stop": (_JOB,),
    "move": (_JOB,),
    "ack": (_JOB, _LONG),
}
_NAME = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-"
_LONGEST_PAYLOAD, _LONGEST_NAME, _LONGEST_LINE = 80, 32, 91
# The clock of the protocol has 32 bits, the number of a sweep 16.
_CLOCK, _MOST_SWEEPS = 4294967296, 65536
# Records are sent again, and changed wheels reported, after this time [us].
_AGAIN = 50000
# Pulses beyond these drive a servo against its stop [us].
_SHORTEST_PULSE, _LONGEST_PULSE = 500, 2500


class Board:
    """What a device is made of; this one has a single sensor that never detects anything."""

    name = "none"
    sensors = 1
    # How many records it can keep.
    window = 64
    # Way of a wheel from count to count [um] and distance between the wheels [0.1 mm]; 0 without wheels.
    tick, base = 0, 0
    # Among "servo", "air", "wheels" and "drive".
    capabilities: tuple[str, ...] = ()

    def advance(self, clock_us: int) -> None:
        """Take the time, before anything else is asked."""

    def servo(self, pulse_us: int) -> None:
        """Turn the servo."""

    def recovering(self) -> list[int]:
        """Return the sensors that cannot be triggered yet: after no echo, some keep their pins high for a while."""
        return []

    def fire(self, sensors: list[int], listen_us: int) -> None:
        """Trigger sensors at once, and listen so long."""

    def flights(self) -> list[int] | None:
        """Return the times of flight of the sensors fired last [us], 0: no echo, -1: faulty; None while they listen."""
        return [0]

    def temperature(self) -> int:
        """Return the temperature of the air [0.01 deg C]."""
        return 2000

    def wheels(self) -> tuple[int, int]:
        """Return the counts of the left and the right wheel since the reset."""
        return (0, 0)

    def depart(self) -> None:
        """Start to drive to the next station."""

    def has_arrived(self) -> bool:
        """Return whether the drive is over; without a drive it never is."""
        return False

    def halt(self) -> None:
        """Stop driving."""


def line_of(payload: str) -> bytes:
    """Frame a payload as a line."""
    return f"${payload}*{binascii.crc32(payload.encode()):08X}\n".encode()


def read_command(line: bytes) -> list[str]:
    """Read a line of the host without its line feed: word and fields; empty if it is damaged or no command."""
    if line.endswith(b"\r"):
        line = line[:-1]
    start = line.rfind(b"$")
    payload, end = line[start + 1 : -9], line[-9:]
    if start < 0 or not 0 < len(payload) <= _LONGEST_PAYLOAD or max(payload) > 126:
        return []
    fields = payload.decode().split(",")
    bounds = _COMMANDS.get(fields[0])
    if end != f"*{binascii.crc32(payload):08X}".encode() or bounds is None or len(bounds) != len(fields) - 1:
        return []
    return fields if all(_is_field(fields[place + 1], bound) for place, bound in enumerate(bounds)) else []


def _is_field(text: str, bounds: tuple[int, ...]) -> bool:
    """Return whether a text is a number within bounds, or a name if there are none."""
    if not bounds:
        return 0 < len(text) <= _LONGEST_NAME and all(each in _NAME for each in text)
    digits = text[1:] if text.startswith("-") else text  # noqa: FURB188 - MicroPython has no removeprefix
    if not digits.isdigit() or len(digits) > 10 or (digits[0] == "0" and text != "0"):
        return False
    return bounds[0] <= int(text) <= bounds[1]


class Head:
    """A device between two resets: give it what arrives and the time, and send what it returns.

    ``advance`` is to be called every millisecond or more often, and only when what it returned before is on its way.
    The clock counts microseconds from any start, never decreases and does not wrap; the lines carry its last 32 bits.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self.settings = {name: default for name, _, _, default in SETTINGS}
        self.settings.update({"tick": board.tick, "base": board.base})
        self._partial = [b""]
        self._output: list[bytes] = []
        # Lines of the records that are not acknowledged.
        self._kept: list[bytes] = []
        # The running job: none or one.
        self._running: list[Iterator[bool]] = []
        # Numbers that change.  "number" is that of the next record, "window" that of the job, "sent" the time of
        # the last line.  "idle" is 1 where the job may end, "stopping" if it is to, "moving" if it is no sweep.
        # "pulse" is 0 before the servo was turned; "turned" is the time of the last report of the wheels.
        names = "clock job number window sent moving idle stopping pulse left right turned damaged"
        self._state = dict.fromkeys(names.split(), 0)
        self._greet()

    @property
    def damaged(self) -> int:
        """Number of lines that were dropped."""
        return self._state["damaged"]

    def receive(self, data: bytes) -> None:
        """Take bytes of the host; the answers come with the next ``advance``."""
        lines = (self._partial[0] + data).split(b"\n")
        # Only the last bytes of endless noise can belong to a command.
        self._partial[0] = lines.pop()[-_LONGEST_LINE:]
        for line in lines:
            fields = read_command(line)
            if fields:
                self._answer(fields)
            elif line.strip():
                self._state["damaged"] += 1

    def advance(self, clock_us: int) -> bytes:
        """Do what is due at this time, and return what is to be sent."""
        state = self._state
        state["clock"] = clock_us
        self.board.advance(clock_us)
        if self._running:
            self._run()
        if self._output:
            state["sent"] = clock_us
        elif self._kept and clock_us - state["sent"] >= _AGAIN:
            self._output.extend(self._kept)
            state["sent"] = clock_us
        data = b"".join(self._output)
        self._output.clear()
        return data

    def _run(self) -> None:
        """Let the job go on until it waits, and end it if it is complete, or stopped and not in a ping."""
        state = self._state
        if not (state["stopping"] and state["idle"]):
            try:
                state["idle"] = next(self._running[0])
            except StopIteration:
                state["stopping"] = state["idle"] = 1
        if state["stopping"] and state["idle"]:
            self._running.clear()
            if state["moving"]:
                self.board.halt()
                self._report_wheels()
            self._record("done", state["clock"])

    def _greet(self) -> None:
        board, words = self.board, "-".join(self.board.capabilities) or "none"
        self._send(f"hello,1,{FIRMWARE},{board.name},{board.sensors},{board.window},{words}")

    def _answer(self, fields: list[str]) -> None:
        """Obey a command."""
        word = fields[0]
        if word == "hello":
            self._greet()
        elif word == "config":
            for setting in SETTINGS:
                self._send(f"value,{setting[0]},{self.settings[setting[0]]}")
        elif word == "ping":
            self._send(f"pong,{fields[1]},{self._state['job']},{self._state['clock'] % _CLOCK}")
        elif word == "set":
            self._set(fields[1], int(fields[2]))
        elif word == "ack":
            self._ack(int(fields[1]), int(fields[2]))
        else:
            self._steer(word, [int(text) for text in fields[1:]])

    def _set(self, name: str, value: int) -> None:
        """Change a setting, or refuse to."""
        limits = [setting for setting in SETTINGS if setting[0] == name]
        if not limits:
            self._send("refused,set,unknown")
        elif self._running:
            self._send("refused,set,busy")
        elif not limits[0][1] <= value <= limits[0][2] or not self._fits(name, value):
            self._send("refused,set,range")
        else:
            self.settings[name] = value
            self._send(f"value,{name},{value}")

    def _fits(self, name: str, value: int) -> bool:
        """Return whether a value fits the board and the other settings."""
        if name == "window":
            return value <= self.board.window
        if name in ("start", "stop"):
            return value < self.settings["stop"] if name == "start" else value > self.settings["start"]
        return name != "gain" or value != 0

    def _ack(self, job: int, following: int) -> None:
        """Forget the records that have arrived."""
        state = self._state
        arrived = len(self._kept) - (state["number"] - following)
        if job == state["job"] and 0 < arrived <= len(self._kept):
            self._kept[:] = self._kept[arrived:]

    def _steer(self, word: str, numbers: list[int]) -> None:
        """Begin or end a job."""
        job, state = numbers[0], self._state
        if word == "move" and not self._has("wheels"):
            self._send("refused,move,unknown")
        elif word == "sweep" and not self._is_in_reach():
            self._send("refused,sweep,range")
        else:
            self._send(f"accepted,{word},{job}")
            if job == state["job"]:
                state["stopping"] |= int(word == "stop")
            elif word != "stop":
                self._begin(job, numbers[1:])

    def _is_in_reach(self) -> bool:
        """Return whether the servo, if there is one, can turn to both ends of a sweep."""
        if not self._has("servo"):
            return True
        pulses = [self._pulse_of(self.settings[name]) for name in ("start", "stop")]
        return min(pulses) >= _SHORTEST_PULSE and max(pulses) <= _LONGEST_PULSE

    def _begin(self, job: int, count: list[int]) -> None:
        """Replace the current job by a number of sweeps, or by a move if there is no number."""
        state = self._state
        if self._running and state["moving"]:
            self.board.halt()
        self._kept.clear()
        self._running[:] = [self._sweeps(count[0] or _MOST_SWEEPS) if count else self._moves()]
        state["window"] = self.settings["window"]
        state["job"], state["number"] = job, 0
        state["moving"], state["idle"], state["stopping"] = int(not count), 1, 0

    def _sweeps(self, count: int) -> "Iterator[bool]":
        """Make sweeps to and fro; yield, whenever it waits, whether the job may end there."""
        state, settings, due = self._state, self.settings, self._state["clock"]
        for sweep in range(count):
            angles = list(range(settings["start"], settings["stop"] + 1, settings["step"]))
            if sweep % 2:
                angles.reverse()
            if not self._has("servo"):
                angles = [0]
            if self._turn(angles[0]):
                due = max(due, state["clock"] + 1000 * settings["settle"])
            yield from self._wait(due)
            self._record("begin", state["clock"], sweep)
            if self._has("air"):
                self._record("air", state["clock"], min(max(self.board.temperature(), -5500), 12500))
            self._report_wheels()
            for place, angle in enumerate(angles):
                yield from self._wait(due)
                due = state["clock"] + 1000 * settings["dwell"]
                due = max(due, (yield from self._step(angle)))
                # What is left of the time is the servo's.
                self._turn(angles[min(place + 1, len(angles) - 1)])
            yield from self._wait(0)
            self._report_wheels()
            self._record("end", state["clock"], sweep)

    def _step(self, angle: int) -> "Generator[bool, None, int]":
        """Fire every sensor once, and return from when on the next may fire."""
        state, settings, every = self._state, self.settings, list(range(self.board.sensors))
        pulse, due = self._pulse_of(angle) if self._has("servo") else 0, 0
        for sensors in [every] if settings["together"] else [[sensor] for sensor in every]:
            yield from self._wait(due)
            while set(sensors) & set(self.board.recovering()):
                yield True
            fired = state["clock"]
            flights = yield from self._listen(sensors)
            for place, sensor in enumerate(sensors):
                self._record("echo", fired, sensor, pulse, angle, flights[place])
            due = 0 if settings["together"] else fired + 1000 * settings["guard"]
        return due

    def _listen(self, sensors: list[int]) -> "Generator[bool, None, list[int]]":
        """Fire sensors and return their times of flight."""
        limit = 1000 * self.settings["listen"]
        self.board.fire(sensors, limit)
        flights = None
        while flights is None:
            yield False
            flights = self.board.flights()
        # A board that was held up may time an echo too late.
        return [flight if flight <= limit else 0 for flight in flights]

    def _moves(self) -> "Iterator[bool]":
        """Report the wheels until the drive is over."""
        self.board.depart()
        self._report_wheels()
        while not self.board.has_arrived():
            yield True
            self._watch_wheels()

    def _wait(self, due: int) -> "Iterator[bool]":
        """Wait until a time, and until there is room for records."""
        state = self._state
        while state["clock"] < due or self._is_full():
            yield True
            self._watch_wheels()

    def _is_full(self) -> bool:
        return 0 < self._state["window"] <= len(self._kept)

    def _has(self, capability: str) -> bool:
        return capability in self.board.capabilities

    def _turn(self, angle: int) -> bool:
        """Turn the servo, and return whether it stood elsewhere."""
        if not self._has("servo"):
            return False
        before, self._state["pulse"] = self._state["pulse"], self._pulse_of(angle)
        self.board.servo(self._state["pulse"])
        return self._state["pulse"] != before

    def _pulse_of(self, angle: int) -> int:
        """Pulse of the servo at an angle [us], rounded to the nearest."""
        return self.settings["zero"] + (self.settings["gain"] * angle + 4500) // 9000

    def _watch_wheels(self) -> None:
        """Report the wheels if they turned and were not reported just before."""
        state = self._state
        if self._has("wheels") and state["clock"] - state["turned"] >= _AGAIN and not self._is_full():
            left, right = self.board.wheels()
            if left != state["left"] or right != state["right"]:
                self._report_wheels()

    def _report_wheels(self) -> None:
        """Report the wheels if there are any."""
        state = self._state
        if self._has("wheels"):
            state["left"], state["right"] = self.board.wheels()
            state["turned"] = state["clock"]
            signed = [(state[side] + 2147483648) % 4294967296 - 2147483648 for side in ("left", "right")]
            self._record("wheels", state["clock"], *signed)

    def _record(self, word: str, clock: int, *fields: int) -> None:
        state = self._state
        # MicroPython unpacks nothing within a list.
        numbers = [state["job"], state["number"], clock % _CLOCK]
        line = line_of(",".join([word] + [str(number) for number in numbers + list(fields)]))
        state["number"] += 1
        self._output.append(line)
        if state["window"]:
            self._kept.append(line)

    def _send(self, payload: str) -> None:
        self._output.append(line_of(payload))
