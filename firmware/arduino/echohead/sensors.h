// Ultrasonic sensors: triggers, and echo pins whose edges are timed in an interrupt.
#pragma once

#include <stdint.h>

namespace sensors {

void begin();
// False while a sensor may still recover from its last ping.
bool is_ready(uint8_t sensor);
// Trigger sensors `first` to `last` at once; returns the time of the trigger [us].
uint32_t trigger(uint8_t first, uint8_t last);
// Whether the ping of a sensor is over: its echo came, or `listen` has passed since the trigger.
bool is_finished(uint8_t sensor, uint32_t listen);
// Time of the last trigger [us].
uint32_t triggered_at(uint8_t sensor);
// Time of flight [us], NO_ECHO or FAULTY_ECHO, of a ping that is over.
uint16_t flight(uint8_t sensor);

}  // namespace sensors
