#include "records.h"

#include "settings.h"

namespace records {

// Records that cannot wait follow when the window is full: the echoes of four sensors that fire together, and then the
// wheels, the end of the sweep, the wheels again and the end of the job. A power of two makes the queue fast.
constexpr uint8_t CAPACITY = 32;
static_assert(CAPACITY >= MOST_UNACKNOWLEDGED + 8, "the queue is too short");
constexpr uint32_t PATIENCE = 50000;  // us

static Record queue[CAPACITY];
static uint16_t current_job;
static uint8_t window;  // that of the settings when the job began
// Numbers of records: the first that is kept, the next to send, and the next to make.
static uint32_t first, unsent, next;

void start(uint16_t job) {
  current_job = job;
  window = settings::get(Window);
  first = unsent = next = 0;
}

uint16_t job() { return current_job; }

bool has_room() {
  return next - first < (window ? window : MOST_UNACKNOWLEDGED);
}

Record &add(RecordKind kind, uint32_t clock) {
  Record &record = queue[next++ % CAPACITY];
  record.kind = kind;
  record.clock = clock;
  return record;
}

void acknowledge(uint16_t job, uint32_t number) {
  if (job != current_job || number <= first || number > next) return;
  first = number;
  if (unsent < first) unsent = first;
}

bool write_next(LineWriter &line, uint32_t silence) {
  if (window == 0) first = unsent;  // nothing is repeated
  if (unsent == next) {
    if (first == next || silence < PATIENCE) return false;
    unsent = first;
  }
  write_record(line, current_job, unsent, queue[unsent % CAPACITY]);
  unsent++;
  return true;
}

}  // namespace records
