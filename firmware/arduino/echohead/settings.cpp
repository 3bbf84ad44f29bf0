#include "settings.h"

#include <avr/pgmspace.h>
#include <string.h>

#include "config.h"
#include "records.h"

namespace settings {

struct Entry {
  char name[9];
  int16_t low, high, initial;
};

static const Entry TABLE[SETTINGS] PROGMEM = {
    {"start", -9000, 9000, DEFAULT_START},
    {"stop", -9000, 9000, DEFAULT_STOP},
    {"step", 10, 4500, DEFAULT_STEP},
    {"zero", 500, 2500, DEFAULT_ZERO},
    {"gain", -1200, 1200, DEFAULT_GAIN},
    {"dwell", 5, 1000, DEFAULT_DWELL},
    {"guard", 5, 250, DEFAULT_GUARD},
    {"together", 0, 1, DEFAULT_TOGETHER},
    {"settle", 0, 5000, DEFAULT_SETTLE},
    {"listen", 5, 60, DEFAULT_LISTEN},
    {"tick", 0, 9000, DEFAULT_TICK},
    {"base", 0, 9000, DEFAULT_BASE},
    {"window", 0, records::MOST_UNACKNOWLEDGED, DEFAULT_WINDOW},
};

static int16_t values[SETTINGS];

void begin() {
  for (uint8_t i = 0; i < SETTINGS; i++) values[i] = pgm_read_word(&TABLE[i].initial);
}

int16_t get(Setting setting) { return values[setting]; }

const char *name(Setting setting) { return TABLE[setting].name; }

Setting find(const char *name) {
  uint8_t i = 0;
  while (i < SETTINGS && strcmp_P(name, TABLE[i].name) != 0) i++;
  return (Setting)i;
}

bool set(Setting setting, int16_t value) {
  const int16_t low = pgm_read_word(&TABLE[setting].low), high = pgm_read_word(&TABLE[setting].high);
  if (value < low || value > high) return false;
  if (setting == Start && value >= values[Stop]) return false;
  if (setting == Stop && value <= values[Start]) return false;
  if (setting == Gain && value == 0) return false;
  values[setting] = value;
  return true;
}

}  // namespace settings
