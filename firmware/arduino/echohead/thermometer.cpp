#include "thermometer.h"

#include <Arduino.h>

#include "config.h"

namespace thermometer {

#if THERMOMETER

constexpr uint8_t READINGS = 16;  // their noise makes the mean finer than the steps of the converter, 0.5 degrees
constexpr int16_t LOWEST = -5000, HIGHEST = 12500;

bool read(int16_t *temperature) {
  uint32_t sum = 0;
  analogRead(THERMOMETER_PIN);  // the first reading after a change of the channel is not settled
  for (uint8_t i = 0; i < READINGS; i++) sum += analogRead(THERMOMETER_PIN);
  // 1 mV is 0.1 degrees, and 500 mV 0 degrees.
  const int32_t value = (int32_t)(sum * SUPPLY_MILLIVOLTS * 10 / (READINGS * 1024UL)) - 5000;
  *temperature = value;
  return value > LOWEST && value <= HIGHEST;
}

#else

bool read(int16_t *) { return false; }

#endif

}  // namespace thermometer
