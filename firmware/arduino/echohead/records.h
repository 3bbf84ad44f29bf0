// The records of a job: a queue that keeps them until they are sent, or with a window until they are acknowledged.
#pragma once

#include "protocol.h"

namespace records {

constexpr uint8_t MOST_UNACKNOWLEDGED = 24;

// Begin with number 0 and an empty queue.
void start(uint16_t job);
uint16_t job();
// Whether a ping may be made, or anything else that can wait.
bool has_room();
// A new record, to be filled in.
Record &add(RecordKind kind, uint32_t clock);
void acknowledge(uint16_t job, uint32_t next);
// Write the next record that is due; false if none is. `silence`: time since the last line [us].
bool write_next(LineWriter &line, uint32_t silence);

}  // namespace records
