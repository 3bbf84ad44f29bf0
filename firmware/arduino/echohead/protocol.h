// The lines of the device protocol (docs/protocol.md). This code does not depend on Arduino: tests compile it on a computer.
#pragma once

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#define PSTR(text) (text)
#define pgm_read_byte(address) (*(const uint8_t *)(address))
#define pgm_read_dword(address) (*(const uint32_t *)(address))
#endif

constexpr uint8_t PROTOCOL_VERSION = 1;
constexpr uint8_t LONGEST_PAYLOAD = 80;
constexpr uint8_t LONGEST_NAME = 32;
constexpr uint8_t CHECKSUM_DIGITS = 8;
// "$", a payload, "*", the checksum and a line feed.
constexpr uint8_t LONGEST_LINE = 1 + LONGEST_PAYLOAD + 1 + CHECKSUM_DIGITS + 1;

uint32_t crc32(const char *text, uint8_t length);

// Joins bytes to lines and drops what is damaged.
class LineReader {
 public:
  // Takes a byte; true if it completes a sound line, whose payload is then valid until the next byte.
  bool feed(char byte);
  char *payload() { return text_; }

 private:
  bool is_sound();

  char text_[LONGEST_PAYLOAD + 1 + CHECKSUM_DIGITS + 1];
  uint8_t length_ = 0;
  bool is_open_ = false;  // a "$" has come, and not too many bytes since
};

// The comma-separated fields of a payload, which are cut in place.
class Fields {
 public:
  explicit Fields(char *payload);
  uint8_t count() const { return count_; }
  const char *operator[](uint8_t index) const { return fields_[index]; }

 private:
  static constexpr uint8_t MOST = 8;
  const char *fields_[MOST];
  uint8_t count_ = 0;  // MOST + 1 if there are more
};

bool is_name(const char *text);
// Read a decimal integer of the protocol within bounds; unsigned ones up to 32 bits.
bool read_integer(const char *text, int32_t low, int32_t high, int32_t *value);
bool read_natural(const char *text, uint32_t high, uint32_t *value);

enum class CommandKind : uint8_t { Damaged, Hello, Config, Set, Ping, Sweep, Stop, Move, Ack };

struct Command {
  CommandKind kind = CommandKind::Damaged;
  const char *word = nullptr;
  const char *name = nullptr;  // of the setting
  int16_t value = 0;           // of the setting
  uint16_t job = 0;            // or the token of a ping
  uint32_t argument = 0;       // count of sweeps, or number of a record
};

// Read a command from a payload, which is changed; the texts in the result point into it.
Command read_command(char *payload);

// Writes one line into a buffer.
class LineWriter {
 public:
  // `word` is in program memory.
  void begin(const char *word);
  void name(const char *text);
  void name_P(const char *text);
  void integer(int32_t value);
  void natural(uint32_t value);
  void finish();
  void clear() { length_ = 0; }
  const char *text() const { return text_; }
  uint8_t length() const { return length_; }

 private:
  void put(char byte) { text_[length_++] = byte; }

  char text_[LONGEST_LINE];
  uint8_t length_ = 0;
};

enum class RecordKind : uint8_t { Begin, Echo, Air, Wheels, End, Done };

constexpr uint16_t NO_ECHO = 0;
constexpr uint16_t FAULTY_ECHO = 0xFFFF;  // written as -1

struct Ping {
  uint8_t sensor;
  uint16_t pulse;   // us
  int16_t angle;    // 0.01 degrees
  uint16_t flight;  // us, NO_ECHO or FAULTY_ECHO
};

struct WheelCounts {
  int32_t left;
  int32_t right;
};

// A record without its job and number, which follow from its place in the queue.
struct Record {
  uint32_t clock;  // us
  RecordKind kind;
  union {
    uint16_t sweep;
    Ping ping;
    int16_t temperature;  // 0.01 degrees Celsius
    WheelCounts wheels;
  };
};

void write_record(LineWriter &line, uint16_t job, uint32_t number, const Record &record);
void write_hello(LineWriter &line, const char *firmware, const char *board, uint8_t sensors, uint8_t window,
                 const char *capabilities);
void write_value(LineWriter &line, const char *name, int16_t value);
void write_pong(LineWriter &line, uint16_t token, uint16_t job, uint32_t clock);
void write_accepted(LineWriter &line, const char *command, uint16_t job);
// `reason` is in program memory.
void write_refused(LineWriter &line, const char *command, const char *reason);
