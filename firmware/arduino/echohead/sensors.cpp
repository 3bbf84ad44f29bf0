#include "sensors.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"
#include "protocol.h"

namespace sensors {

static const uint8_t trigger_pins[] = {TRIGGER_PINS};
static const uint8_t echo_pins[] = {ECHO_PINS};
static_assert(SENSORS >= 1 && SENSORS <= 4, "1 to 4 sensors");
static_assert(sizeof trigger_pins >= SENSORS && sizeof echo_pins >= SENSORS, "each sensor has two pins");

enum State : uint8_t { Idle, Triggered, Echoing, Heard, Stuck };

struct Channel {
  volatile uint8_t *trigger_port;
  uint8_t trigger_mask;
  uint8_t echo_mask;
  volatile State state;
  uint32_t triggered;
  uint32_t rise;
  uint32_t fall;
};

static Channel channels[SENSORS];

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
}

static void set_triggers(uint8_t first, uint8_t last, bool is_high) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    for (uint8_t i = first; i <= last; i++) {
      if (is_high) {
        *channels[i].trigger_port |= channels[i].trigger_mask;
      } else {
        *channels[i].trigger_port &= ~channels[i].trigger_mask;
      }
    }
  }
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
  return state == Heard || state == Stuck || micros() - channel.triggered >= listen;
}

uint32_t triggered_at(uint8_t sensor) { return channels[sensor].triggered; }

uint16_t flight(uint8_t sensor) {
  Channel &channel = channels[sensor];
  uint16_t flight = NO_ECHO;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    if (channel.state == Heard) flight = channel.fall - channel.rise;
    if (channel.state == Stuck || channel.state == Triggered) flight = FAULTY_ECHO;
    channel.state = Idle;
  }
  return flight;
}

}  // namespace sensors

// Port C: A0 to A5. It takes a few microseconds, so that echoes at nearly the same time are both timed well.
ISR(PCINT1_vect) {
  const uint32_t now = micros();
  const uint8_t pins = PINC;
  for (sensors::Channel &channel : sensors::channels) {
    const bool is_high = pins & channel.echo_mask;
    if (channel.state == sensors::Triggered && is_high) {
      channel.rise = now;
      channel.state = sensors::Echoing;
    } else if (channel.state == sensors::Echoing && !is_high) {
      channel.fall = now;
      channel.state = sensors::Heard;
    }
  }
}
