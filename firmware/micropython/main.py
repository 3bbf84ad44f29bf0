"""A device with ultrasonic sensors on an ESP32 or a Pico W: fill in the configuration, and copy it to the board.

mpremote cp firmware/micropython/*.py src/echoplan/hardware/head.py : + reset
"""

# ---- Configuration -------------------------------------------------------------------------------------------------

# What the host calls the board: letters, digits, ".", "_" and "-".
NAME = "esp32"
# Trigger and echo pin of each sensor.  HC-SR04 at 5 V need a divider or a level shifter at the echo pin.
SENSORS = [(16, 34), (17, 35), (18, 36), (19, 39)]
# Pin of the servo, or None.
SERVO = 13
# Pin of an analogue TMP36, or None.
THERMOMETER = None
# Pins A and B of the left and of the right wheel encoder, or None: ((25, 26), (27, 14)).
ENCODERS = None
# Way of a wheel from count to count [um], and distance between the wheels [0.1 mm]; 0 without wheels.
TICK, BASE = 0, 0
# Wi-Fi; with an empty name there is only USB.
WIFI_NAME, WIFI_PASSWORD = "", ""
# The board is found as echoplan.local where the firmware has mDNS.
HOST_NAME, PORT = "echoplan", 4000

# ---- End of the configuration --------------------------------------------------------------------------------------

import time  # noqa: E402 - the configuration comes first

from head import Head  # noqa: E402
from machine import ADC, PWM, Pin  # noqa: E402
from pins import Encoder, PinBoard  # noqa: E402
from ports import TcpPort, UsbPort, serve  # noqa: E402


def make_board():
    """Make the board that the configuration describes."""
    sensors = [(Pin(trigger, Pin.OUT), Pin(echo, Pin.IN)) for trigger, echo in SENSORS]
    thermometer = None
    if THERMOMETER is not None:
        adc = ADC(Pin(THERMOMETER))

        def thermometer():
            # 500 mV at 0 degrees, 10 mV a degree; full scale is 3.3 V.
            return (adc.read_u16() * 33000 // 65535 - 5000) * 10

    return PinBoard(
        name=NAME,
        sensors=sensors,
        servo=None if SERVO is None else PWM(Pin(SERVO), freq=50),
        thermometer=thermometer,
        encoders=[Encoder(*(Pin(pin, Pin.IN, Pin.PULL_UP) for pin in pins)) for pins in ENCODERS or ()],
        tick=TICK,
        base=BASE,
    )


def join_wifi():
    """Join the network, and keep trying for ten seconds."""
    import network  # noqa: PLC0415 - not on every board

    if hasattr(network, "hostname"):
        network.hostname(HOST_NAME)
    station = network.WLAN(network.STA_IF)
    station.active(True)
    station.connect(WIFI_NAME, WIFI_PASSWORD)
    for _ in range(100):
        if station.isconnected():
            return
        time.sleep_ms(100)


ports = [UsbPort()]
if WIFI_NAME:
    join_wifi()
    ports.append(TcpPort(PORT))
serve(Head(make_board()), ports)
