// Sweeps to and fro: what the servo and the sensors do, and when.
#pragma once

#include <stdint.h>

namespace sweep {

// Whether a job is running: settings must not change.
bool is_busy();
// Whether the servo can reach both ends of a sweep.
bool is_reachable();
// Begin a job of `count` sweeps; 0: until stopped.
void start(uint16_t job, uint16_t count);
// Begin a job that reports the wheels.
void start_move(uint16_t job);
// End the job after the current ping.
void stop(uint16_t job);
// Do what is due.
void update();
// Whether nothing is due within the next millisecond, unless something arrives.
bool is_waiting();

}  // namespace sweep
