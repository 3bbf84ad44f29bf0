// An analogue thermometer.
#pragma once

#include <stdint.h>

namespace thermometer {

// Temperature [0.01 degrees Celsius]; false if there is no thermometer, or none that can be right. Takes 2 ms.
bool read(int16_t *temperature);

}  // namespace thermometer
