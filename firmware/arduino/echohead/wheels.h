// Wheel encoders, counted in interrupts.
#pragma once

#include "protocol.h"

namespace wheels {

void begin();
// Counts since the reset, forward positive.
WheelCounts counts();

}  // namespace wheels
