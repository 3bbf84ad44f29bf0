#include "servo.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"

#if SERVO
static_assert(SERVO_PIN == 9, "Timer1 drives the servo on D9");
#endif

namespace servo {

// The timer counts half microseconds; a frame has 20 ms.
constexpr uint16_t TICKS_PER_MICROSECOND = 2;
constexpr uint16_t FRAME = 40000;
// A new frame begins no sooner than 5 ms after the last one: servos accept that.
constexpr uint16_t SHORTEST_FRAME = 10000;

static uint16_t current_pulse;
static enum : uint8_t { Informed, Waiting, Pulsing } state;

#if SERVO
// The output is high until the timer has passed its compare value.
static uint16_t compare_value(uint16_t pulse) { return TICKS_PER_MICROSECOND * pulse - 1; }
#endif

void begin(uint16_t pulse) {
  current_pulse = pulse;
#if SERVO
  pinMode(SERVO_PIN, OUTPUT);
  ICR1 = FRAME - 1;
  OCR1A = compare_value(pulse);
  TCCR1A = _BV(COM1A1) | _BV(WGM11);
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS11);
#endif
}

void turn(uint16_t pulse) {
  if (pulse == current_pulse) return;
  current_pulse = pulse;
#if SERVO
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { OCR1A = compare_value(pulse); }
  state = Waiting;
#endif
}

uint16_t pulse() { return current_pulse; }

void update() {
#if SERVO
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    // The timer takes a new pulse at the beginning of a frame: begin one now rather than in up to 20 ms.
    const uint16_t count = TCNT1;
    if (state == Waiting && count >= SHORTEST_FRAME) {
      if (count < FRAME - 100) TCNT1 = FRAME - 2;
      state = Pulsing;
    } else if (state == Pulsing && count > TICKS_PER_MICROSECOND * current_pulse && count < FRAME - 100) {
      state = Informed;
    }
  }
#endif
}

bool is_informed() { return state == Informed; }

}  // namespace servo
