#include "protocol.h"

#include <string.h>

// The CRC-32 of zlib by half bytes: a table of 64 bytes instead of 1024.
static const uint32_t CRC_TABLE[16] PROGMEM = {
    0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
    0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
};

uint32_t crc32(const char *text, uint8_t length) {
  uint32_t crc = 0xFFFFFFFF;
  for (uint8_t i = 0; i < length; i++) {
    const uint8_t byte = text[i];
    crc = (crc >> 4) ^ pgm_read_dword(&CRC_TABLE[(crc ^ byte) & 15]);
    crc = (crc >> 4) ^ pgm_read_dword(&CRC_TABLE[(crc ^ (byte >> 4)) & 15]);
  }
  return ~crc;
}

static char hex_digit(uint8_t value) { return value < 10 ? '0' + value : 'A' + value - 10; }

static bool is_digit(char byte) { return byte >= '0' && byte <= '9'; }

bool LineReader::feed(char byte) {
  if (byte == '$') {  // a line begins at the last one
    length_ = 0;
    is_open_ = true;
    return false;
  }
  if (byte == '\n') {
    const bool is_line = is_open_ && is_sound();
    is_open_ = false;
    return is_line;
  }
  if (length_ == sizeof text_) is_open_ = false;
  if (is_open_) text_[length_++] = byte;
  return false;
}

bool LineReader::is_sound() {
  if (length_ > 0 && text_[length_ - 1] == '\r') length_--;
  if (length_ < 1 + 1 + CHECKSUM_DIGITS) return false;
  const uint8_t end = length_ - CHECKSUM_DIGITS - 1;
  if (text_[end] != '*' || end > LONGEST_PAYLOAD) return false;
  uint32_t crc = crc32(text_, end);
  for (uint8_t i = length_ - 1; i > end; i--, crc >>= 4) {
    if (text_[i] != hex_digit(crc & 15)) return false;
  }
  for (uint8_t i = 0; i < end; i++) {
    if (text_[i] < ' ' || text_[i] > '~' || text_[i] == '*') return false;
  }
  text_[end] = 0;
  return true;
}

Fields::Fields(char *payload) {
  fields_[count_++] = payload;
  for (char *at = payload; (at = strchr(at, ',')) != nullptr;) {
    *at++ = 0;
    if (count_ == MOST) {
      count_++;
      return;
    }
    fields_[count_++] = at;
  }
}

bool is_name(const char *text) {
  uint8_t length = 0;
  for (; text[length]; length++) {
    const char byte = text[length];
    const bool is_letter = (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z');
    if (!is_letter && !is_digit(byte) && byte != '.' && byte != '_' && byte != '-') return false;
  }
  return length > 0 && length <= LONGEST_NAME;
}

bool read_natural(const char *text, uint32_t high, uint32_t *value) {
  if (!is_digit(text[0]) || (text[0] == '0' && text[1])) return false;
  uint32_t sum = 0;
  for (; *text; text++) {
    if (!is_digit(*text)) return false;
    const uint8_t digit = *text - '0';
    if (sum > high / 10 || (sum == high / 10 && digit > high % 10)) return false;
    sum = 10 * sum + digit;
  }
  *value = sum;
  return true;
}

bool read_integer(const char *text, int32_t low, int32_t high, int32_t *value) {
  uint32_t size;
  if (text[0] != '-') {
    if (!read_natural(text, high, &size)) return false;
    *value = size;
    return *value >= low;
  }
  if (low >= 0 || text[1] == '0' || !read_natural(text + 1, -(uint32_t)low, &size)) return false;
  *value = -size;
  return true;
}

static bool read_setting(const Fields &fields, Command *command) {
  int32_t value;
  if (!is_name(fields[1]) || !read_integer(fields[2], -9000, 9000, &value)) return false;
  command->name = fields[1];
  command->value = value;
  return true;
}

struct Form {
  char word[7];
  CommandKind kind;
  uint8_t fields;
};

static const Form FORMS[] PROGMEM = {
    {"hello", CommandKind::Hello, 1}, {"config", CommandKind::Config, 1}, {"set", CommandKind::Set, 3},
    {"ping", CommandKind::Ping, 2},   {"sweep", CommandKind::Sweep, 3},   {"stop", CommandKind::Stop, 2},
    {"move", CommandKind::Move, 2},   {"ack", CommandKind::Ack, 3},
};

#ifdef __AVR__
static bool equals_P(const char *text, const char *other) { return strcmp_P(text, other) == 0; }
#else
static bool equals_P(const char *text, const char *other) { return strcmp(text, other) == 0; }
#endif

static bool read_job(const Fields &fields, Command *command) {
  uint32_t number;
  if (!read_natural(fields[1], 0xFFFF, &number)) return false;
  command->job = number;
  return number > 0 || command->kind == CommandKind::Ping;
}

Command read_command(char *payload) {
  const Fields fields(payload);
  Command command;
  command.word = fields[0];
  for (const Form &form : FORMS) {
    if (fields.count() == pgm_read_byte(&form.fields) && equals_P(command.word, form.word)) {
      command.kind = (CommandKind)pgm_read_byte(&form.kind);
    }
  }
  bool is_sound = true;
  if (command.kind == CommandKind::Set) {
    is_sound = read_setting(fields, &command);
  } else if (fields.count() > 1) {
    const uint32_t high = command.kind == CommandKind::Ack ? 0xFFFFFFFF : 0xFFFF;
    is_sound = read_job(fields, &command) && (fields.count() == 2 || read_natural(fields[2], high, &command.argument));
  }
  if (!is_sound) command.kind = CommandKind::Damaged;
  return command;
}

void LineWriter::begin(const char *word) {
  length_ = 0;
  put('$');
  for (char byte; (byte = pgm_read_byte(word)); word++) put(byte);
}

void LineWriter::name(const char *text) {
  put(',');
  while (*text) put(*text++);
}

void LineWriter::name_P(const char *text) {
  put(',');
  for (char byte; (byte = pgm_read_byte(text)); text++) put(byte);
}

void LineWriter::natural(uint32_t value) {
  put(',');
  char digits[10];
  uint8_t count = 0;
  // Most numbers are small, and a division by 16 bits takes a third of the time.
  for (; value > 0xFFFF; value /= 10) digits[count++] = '0' + value % 10;
  uint16_t rest = value;
  do {
    digits[count++] = '0' + rest % 10;
    rest /= 10;
  } while (rest);
  while (count) put(digits[--count]);
}

void LineWriter::integer(int32_t value) {
  natural(value < 0 ? -(uint32_t)value : value);
  if (value >= 0) return;
  // The minus sign goes between the comma and the digits.
  uint8_t at = length_++;
  for (; text_[at - 1] != ','; at--) text_[at] = text_[at - 1];
  text_[at] = '-';
}

void LineWriter::finish() {
  const uint32_t crc = crc32(text_ + 1, length_ - 1);
  put('*');
  for (int8_t shift = 28; shift >= 0; shift -= 4) put(hex_digit((crc >> shift) & 15));
  put('\n');
}

static const char *word_of(RecordKind kind) {
  switch (kind) {
    case RecordKind::Begin: return PSTR("begin");
    case RecordKind::Echo: return PSTR("echo");
    case RecordKind::Air: return PSTR("air");
    case RecordKind::Wheels: return PSTR("wheels");
    case RecordKind::End: return PSTR("end");
    default: return PSTR("done");
  }
}

void write_record(LineWriter &line, uint16_t job, uint32_t number, const Record &record) {
  line.begin(word_of(record.kind));
  line.natural(job);
  line.natural(number);
  line.natural(record.clock);
  switch (record.kind) {
    case RecordKind::Begin:
    case RecordKind::End:
      line.natural(record.sweep);
      break;
    case RecordKind::Echo:
      line.natural(record.ping.sensor);
      line.natural(record.ping.pulse);
      line.integer(record.ping.angle);
      line.integer(record.ping.flight == FAULTY_ECHO ? -1 : (int32_t)record.ping.flight);
      break;
    case RecordKind::Air:
      line.integer(record.temperature);
      break;
    case RecordKind::Wheels:
      line.integer(record.wheels.left);
      line.integer(record.wheels.right);
      break;
    case RecordKind::Done:
      break;
  }
  line.finish();
}

void write_hello(LineWriter &line, const char *firmware, const char *board, uint8_t sensors, uint8_t window,
                 const char *capabilities) {
  line.begin(PSTR("hello"));
  line.natural(PROTOCOL_VERSION);
  line.name_P(firmware);
  line.name_P(board);
  line.natural(sensors);
  line.natural(window);
  line.name_P(capabilities);
  line.finish();
}

void write_value(LineWriter &line, const char *name, int16_t value) {
  line.begin(PSTR("value"));
  line.name_P(name);
  line.integer(value);
  line.finish();
}

void write_pong(LineWriter &line, uint16_t token, uint16_t job, uint32_t clock) {
  line.begin(PSTR("pong"));
  line.natural(token);
  line.natural(job);
  line.natural(clock);
  line.finish();
}

void write_accepted(LineWriter &line, const char *command, uint16_t job) {
  line.begin(PSTR("accepted"));
  line.name(command);
  line.natural(job);
  line.finish();
}

void write_refused(LineWriter &line, const char *command, const char *reason) {
  line.begin(PSTR("refused"));
  line.name(command);
  line.name_P(reason);
  line.finish();
}
