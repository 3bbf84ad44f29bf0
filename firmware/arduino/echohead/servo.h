// The servo on D9, driven by the hardware PWM of Timer1: no interrupt disturbs its pulses, and it disturbs none.
#pragma once

#include <stdint.h>

namespace servo {

constexpr int16_t SHORTEST_PULSE = 500, LONGEST_PULSE = 2500;  // us

void begin(uint16_t pulse);
void turn(uint16_t pulse);
uint16_t pulse();
// Call it often: it starts the first pulse after a turn.
void update();
// Whether the servo has received the pulse of the last turn.
bool is_informed();

}  // namespace servo
