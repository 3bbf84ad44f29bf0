#include "wheels.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"

namespace wheels {

#if WHEELS

constexpr uint8_t left_pins[] = {LEFT_WHEEL_PINS};
constexpr uint8_t right_pins[] = {RIGHT_WHEEL_PINS};
static_assert(sizeof left_pins >= WHEELS && sizeof right_pins >= WHEELS, "a wheel has a pin for each channel");
static_assert(left_pins[0] <= 7 && left_pins[WHEELS - 1] <= 7, "the left wheel is on D0 to D7");
static_assert(right_pins[0] >= 8 && right_pins[0] <= 13 && right_pins[WHEELS - 1] >= 8 && right_pins[WHEELS - 1] <= 13,
              "the right wheel is on D8 to D13");

struct Encoder {
  volatile uint8_t *port;
  uint8_t a, b;  // masks; b is 0 with one channel
  uint8_t last;  // 2 a + b
  int32_t count;
};

static Encoder left, right;

// Change of the count from the last state (2 a + b) to the next: forward is 0, 2, 3, 1.
static const int8_t STEPS[4][4] = {{0, -1, 1, 0}, {1, 0, 0, -1}, {-1, 0, 0, 1}, {0, 1, -1, 0}};

static uint8_t read(const Encoder &encoder) {
  const uint8_t pins = *encoder.port;
  return (pins & encoder.a ? 2 : 0) | (pins & encoder.b ? 1 : 0);
}

static void update(Encoder &encoder) {
  const uint8_t state = read(encoder);
#if WHEELS == 1
  encoder.count += state != encoder.last;
#else
  encoder.count += STEPS[encoder.last][state];
#endif
  encoder.last = state;
}

static void begin_wheel(Encoder &encoder, const uint8_t *pins) {
  for (uint8_t i = 0; i < WHEELS; i++) {
    pinMode(pins[i], INPUT_PULLUP);
    *digitalPinToPCMSK(pins[i]) |= _BV(digitalPinToPCMSKbit(pins[i]));
  }
  encoder.port = portInputRegister(digitalPinToPort(pins[0]));
  encoder.a = digitalPinToBitMask(pins[0]);
  encoder.b = WHEELS > 1 ? digitalPinToBitMask(pins[1]) : 0;
  encoder.last = read(encoder);
}

void begin() {
  begin_wheel(left, left_pins);
  begin_wheel(right, right_pins);
  PCICR |= _BV(PCIE0) | _BV(PCIE2);
}

WheelCounts counts() {
  WheelCounts counts;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { counts = {left.count, right.count}; }
  return counts;
}

#else

void begin() {}
WheelCounts counts() { return {0, 0}; }

#endif

}  // namespace wheels

#if WHEELS
ISR(PCINT2_vect) { wheels::update(wheels::left); }   // port D: D0 to D7
ISR(PCINT0_vect) { wheels::update(wheels::right); }  // port B: D8 to D13
#endif
