// Sweeps to and fro: what the servo and the sensors do, and when.
#pragma once

#include <stdint.h>

namespace sweep {

// Whether a session is running: settings must not change.
bool is_busy();
// Whether the servo can reach both ends of a sweep.
bool is_reachable();
// Begin a session of `count` sweeps; 0: until stopped.
void start(uint16_t session, uint16_t count);
// Begin a session that reports the wheels.
void start_move(uint16_t session);
// End the session after the current ping.
void stop(uint16_t session);
// Do what is due.
void update();
// Whether nothing is due within the next millisecond, unless something arrives.
bool is_waiting();

}  // namespace sweep
