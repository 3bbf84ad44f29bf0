// The settings of the device: their names, bounds and values.
#pragma once

#include <stdint.h>

enum Setting : uint8_t {
  Start, Stop, Step, Zero, Gain, Dwell, Guard, Together, Settle, Listen, Tick, Base, Window, SETTINGS
};

namespace settings {

void begin();
int16_t get(Setting setting);
// In program memory.
const char *name(Setting setting);
// SETTINGS if there is none of this name.
Setting find(const char *name);
// Change a setting; false if the value is out of range.
bool set(Setting setting, int16_t value);

}  // namespace settings
