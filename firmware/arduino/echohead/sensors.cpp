#include "sensors.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"
#include "protocol.h"

namespace sensors {

constexpr uint8_t trigger_pins[] = {TRIGGER_PINS};
constexpr uint8_t echo_pins[] = {ECHO_PINS};
static_assert(SENSORS >= 1 && SENSORS <= 4, "1 to 4 sensors");
static_assert(sizeof trigger_pins >= SENSORS && sizeof echo_pins >= SENSORS, "each sensor has two pins");

constexpr bool are_on_port_c(uint8_t i = 0) {
  return i == SENSORS || (echo_pins[i] >= A0 && echo_pins[i] <= A5 && are_on_port_c(i + 1));
}
static_assert(are_on_port_c(), "the echo pins are among A0 to A5");

// A sensor that detects no echo keeps its echo pin high for 38 ms, some kinds for 200 ms, and ignores triggers.
constexpr uint32_t LONGEST_RECOVERY = 200000;  // us

enum State : uint8_t { Idle, Triggered, Echoing, Received, Stuck };

// micros() has steps of 4 us. Timer2 adds half microseconds, of which it counts 256 before it begins again.
struct Edge {
  uint32_t time;
  uint8_t fine;
};

struct Channel {
  volatile uint8_t *trigger_port;
  uint8_t trigger_mask;
  uint8_t echo_mask;
  volatile State state;
  uint32_t triggered;
  Edge rise;
  Edge fall;
};

static Channel channels[SENSORS];

// Time from edge to edge [us].
static uint16_t between(const Edge &rise, const Edge &fall) {
  const uint32_t steps = 2 * (fall.time - rise.time);
  const int8_t correction = (uint8_t)(fall.fine - rise.fine) - (uint8_t)steps;
  return (steps + correction + 1) / 2;
}

void begin() {
  for (uint8_t i = 0; i < SENSORS; i++) {
    Channel &channel = channels[i];
    pinMode(trigger_pins[i], OUTPUT);
    pinMode(echo_pins[i], INPUT);
    channel.trigger_port = portOutputRegister(digitalPinToPort(trigger_pins[i]));
    channel.trigger_mask = digitalPinToBitMask(trigger_pins[i]);
    channel.echo_mask = digitalPinToBitMask(echo_pins[i]);
    PCMSK1 |= channel.echo_mask;
  }
  PCICR |= _BV(PCIE1);
  TCCR2A = 0;
  TCCR2B = _BV(CS21);  // a tick of half a microsecond
}

static void set_triggers(uint8_t first, uint8_t last, bool is_high) {
  for (uint8_t i = first; i <= last;) {
    // All triggers on one port change at once.
    volatile uint8_t *port = channels[i].trigger_port;
    uint8_t mask = 0;
    for (; i <= last && channels[i].trigger_port == port; i++) mask |= channels[i].trigger_mask;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { *port = is_high ? *port | mask : *port & ~mask; }
  }
}

bool is_ready(uint8_t sensor) {
  const Channel &channel = channels[sensor];
  const bool is_low = !(PINC & channel.echo_mask);
  return is_low || channel.state == Stuck || micros() - channel.triggered >= LONGEST_RECOVERY;
}

uint32_t trigger(uint8_t first, uint8_t last) {
  const uint32_t now = micros();
  for (uint8_t i = first; i <= last; i++) {
    channels[i].triggered = now;
    channels[i].state = PINC & channels[i].echo_mask ? Stuck : Triggered;
  }
  set_triggers(first, last, true);
  delayMicroseconds(10);
  set_triggers(first, last, false);
  return now;
}

bool is_finished(uint8_t sensor, uint32_t listen) {
  const Channel &channel = channels[sensor];
  const State state = channel.state;
  return state == Received || state == Stuck || micros() - channel.triggered >= listen;
}

uint32_t triggered_at(uint8_t sensor) { return channels[sensor].triggered; }

uint16_t flight(uint8_t sensor) {
  Channel &channel = channels[sensor];
  uint16_t flight = NO_ECHO;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    if (channel.state == Received) flight = between(channel.rise, channel.fall);
    if (channel.state == Stuck || channel.state == Triggered) flight = FAULTY_ECHO;
    if (channel.state != Stuck) channel.state = Idle;
  }
  return flight;
}

}  // namespace sensors

// Port C: A0 to A5.
ISR(PCINT1_vect) {
  static uint8_t last_pins;
  uint8_t pins = PINC;
  do {
    const uint8_t fine = TCNT2, changed = pins ^ last_pins;
    const sensors::Edge now = {micros(), fine};
    for (sensors::Channel &channel : sensors::channels) {
      if (!(changed & channel.echo_mask)) continue;
      const bool is_high = pins & channel.echo_mask;
      if (channel.state == sensors::Triggered && is_high) {
        channel.rise = now;
        channel.state = sensors::Echoing;
      } else if (channel.state == sensors::Echoing && !is_high) {
        channel.fall = now;
        channel.state = sensors::Received;
      }
    }
    last_pins = pins;
    // Another edge may have come meanwhile: leaving and entering the interrupt would take longer.
    pins = PINC;
  } while (pins != last_pins);
}
