#include "sweep.h"

#include <Arduino.h>

#include "config.h"
#include "records.h"
#include "sensors.h"
#include "servo.h"
#include "settings.h"
#include "thermometer.h"
#include "wheels.h"

namespace sweep {

constexpr uint32_t WHEELS_PERIOD = 50000;  // us

static enum : uint8_t { Idle, Settling, Pinging, Moving } state;
static bool is_stopping;
static uint16_t count, number;  // sweeps to make, and number of the current one
static uint16_t step;           // within the sweep
static uint32_t due_at;         // of the next trigger or the next sweep [us]
static uint32_t step_began_at;
static uint8_t triggered, reported;  // sensors in the current step
#if WHEELS
static WheelCounts reported_counts;
static uint32_t wheels_reported_at;
#endif

static uint32_t microseconds(Setting setting) { return 1000UL * settings::get(setting); }

// Whether the time for the next trigger or sweep has come, and the queue has room for its records.
static bool is_due() {
  const uint32_t now = micros();
  if ((int32_t)(now - due_at) < 0) return false;
  due_at = now;  // a time that is long past would seem to be in the future after half a turn of the clock
  return records::has_room();
}

static bool is_odd() { return number & 1; }

// Number of the last step: the servo turns by whole steps, and to the last angle only if it is one of them.
static uint16_t last_step() {
#if SERVO
  return ((int32_t)settings::get(Stop) - settings::get(Start)) / settings::get(Step);
#else
  return 0;
#endif
}

// Angle of the current step [0.01 degrees].
static int16_t angle() {
#if SERVO
  const uint16_t steps = is_odd() ? last_step() - step : step;
  return settings::get(Start) + (int32_t)steps * settings::get(Step);
#else
  return 0;
#endif
}

static int16_t pulse_at(int16_t angle) {
  // Rounded to the nearest: the quotient of a negative number would be rounded towards zero.
  const int32_t turned = (int32_t)settings::get(Gain) * angle + 4500;
  return settings::get(Zero) + turned / 9000 - (turned % 9000 < 0);
}

bool is_reachable() {
#if SERVO
  const int16_t first = pulse_at(settings::get(Start)), last = pulse_at(settings::get(Stop));
  return min(first, last) >= servo::SHORTEST_PULSE && max(first, last) <= servo::LONGEST_PULSE;
#else
  return true;
#endif
}

bool is_busy() { return state != Idle; }

static void add_wheels() {
#if WHEELS
  reported_counts = wheels::counts();
  wheels_reported_at = micros();
  records::add(RecordKind::Wheels, wheels_reported_at).wheels = reported_counts;
#endif
}

static void add_wheels_if_due() {
#if WHEELS
  // The times of records do not decrease: no record comes between a trigger and its echo.
  if (triggered != reported || !records::has_room() || micros() - wheels_reported_at < WHEELS_PERIOD) return;
  const WheelCounts counts = wheels::counts();
  if (counts.left != reported_counts.left || counts.right != reported_counts.right) add_wheels();
#endif
}

// Turn the servo to the beginning of a sweep, and let it settle if it jumps.
static void approach() {
  state = Settling;
  step = 0;
  triggered = reported = 0;
#if SERVO
  const uint16_t before = servo::pulse();
  servo::turn(pulse_at(angle()));
  if (servo::pulse() != before) due_at = micros() + microseconds(Settle);
#endif
}

static void start_job(uint16_t job) {
  records::start(job);
  // Echoes of pings that are abandoned must not reach the first ping.
  due_at = micros() + (triggered != reported ? microseconds(Listen) : 0);
  triggered = reported = 0;
  is_stopping = false;
}

void start(uint16_t job, uint16_t sweeps) {
  start_job(job);
  count = sweeps;
  number = 0;
  approach();
}

void start_move(uint16_t job) {
  start_job(job);
  state = Moving;
  add_wheels();
}

void stop(uint16_t job) {
  if (job == records::job() && state != Idle) is_stopping = true;
}

static void begin_sweep() {
  records::add(RecordKind::Begin, micros()).sweep = number;
  const uint32_t now = micros();
  int16_t temperature;
  if (thermometer::read(&temperature)) records::add(RecordKind::Air, now).temperature = temperature;
  add_wheels();
  state = Pinging;
}

static void end_job() {
  records::add(RecordKind::Done, micros());
  state = Idle;
}

static void end_sweep() {
  add_wheels();
  records::add(RecordKind::End, micros()).sweep = number;
  number++;
  if (number == count) {
    end_job();
  } else {
    approach();
  }
}

// After the pings of a step the servo turns, so that it has the rest of the dwell for it.
static void end_step() {
  const uint32_t dwelt_at = step_began_at + microseconds(Dwell);
  // The guard time lasts beyond the step.
  if (settings::get(Together) || (int32_t)(dwelt_at - due_at) > 0) due_at = dwelt_at;
  if (step == last_step()) return end_sweep();
  step++;
  triggered = reported = 0;
#if SERVO
  servo::turn(pulse_at(angle()));
#endif
}

static void trigger_if_due() {
  if (triggered != reported || !servo::is_informed() || !is_due()) return;
  const uint8_t last = settings::get(Together) ? SENSORS - 1 : triggered;
  for (uint8_t i = triggered; i <= last; i++) {
    if (!sensors::is_ready(i)) return;
  }
  const uint32_t now = sensors::trigger(triggered, last);
  if (triggered == 0) step_began_at = now;
  triggered = last + 1;
  due_at = now + microseconds(Guard);
}

static void report_echoes() {
  while (reported < triggered && sensors::is_finished(reported, microseconds(Listen))) {
#if SERVO
    const uint16_t pulse = servo::pulse();
#else
    const uint16_t pulse = 0;
#endif
    records::add(RecordKind::Echo, sensors::triggered_at(reported)).ping = {
        reported, pulse, angle(), sensors::flight(reported)};
    reported++;
  }
}

void update() {
  if (state == Idle) return;
  if (state == Pinging) report_echoes();
  if (is_stopping && triggered == reported) {
    if (state == Moving) add_wheels();
    end_job();
    return;
  }
  add_wheels_if_due();
  if (state == Settling && is_due()) begin_sweep();
  if (state != Pinging) return;
  if (triggered < SENSORS) {
    trigger_if_due();
  } else if (reported == SENSORS) {
    end_step();
  }
}

bool is_waiting() {
  if (state == Idle || state == Moving || !records::has_room()) return true;
  return triggered != reported || (int32_t)(due_at - micros()) > 2 * 1024;
}

}  // namespace sweep
