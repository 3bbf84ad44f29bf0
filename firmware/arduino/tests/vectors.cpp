// Reads the shared vectors of the protocol (tests/golden/protocol/lines.tsv) with the code of the firmware, and writes
// them again. Prints a line for each that comes out wrong, and the number of vectors.

#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "../echohead/protocol.h"

using std::string;

// Read a field into a variable of any type; false if it is out of bounds.
template <typename T>
bool natural(const char *text, uint32_t high, T *value) {
  uint32_t number = 0;
  if (!read_natural(text, high, &number)) return false;
  *value = number;
  return true;
}

template <typename T>
bool integer(const char *text, int32_t low, int32_t high, T *value) {
  int32_t number = 0;
  if (!read_integer(text, low, high, &number)) return false;
  *value = number;
  return true;
}

static string command_again(char *payload) {
  const Command command = read_command(payload);
  LineWriter line;
  if (command.kind == CommandKind::Damaged) return "-";
  line.begin(command.word);
  if (command.kind == CommandKind::Set) {
    line.name(command.name);
    line.integer(command.value);
  } else if (command.kind != CommandKind::Hello && command.kind != CommandKind::Config) {
    line.natural(command.job);
  }
  if (command.kind == CommandKind::Sweep || command.kind == CommandKind::Ack) line.natural(command.argument);
  line.finish();
  return string(line.text(), line.length());
}

// Read the fields that follow the clock of a record; false if they are no record.
static bool read_record(const string &word, const Fields &fields, Record *record) {
  const uint8_t count = fields.count();
  int32_t flight = 0;
  if (word == "begin" || word == "end") {
    record->kind = word == "begin" ? RecordKind::Begin : RecordKind::End;
    return count == 5 && natural(fields[4], 65535, &record->sweep);
  }
  if (word == "echo") {
    record->kind = RecordKind::Echo;
    const bool is_sound = count == 8 && natural(fields[4], 7, &record->ping.sensor) &&
                          natural(fields[5], 2500, &record->ping.pulse) &&
                          integer(fields[6], -9000, 9000, &record->ping.angle) &&
                          integer(fields[7], -1, 65534, &flight);
    record->ping.flight = flight < 0 ? FAULTY_ECHO : flight;
    return is_sound;
  }
  if (word == "air") {
    record->kind = RecordKind::Air;
    return count == 5 && integer(fields[4], -5500, 12500, &record->temperature);
  }
  if (word == "wheels") {
    record->kind = RecordKind::Wheels;
    return count == 6 && integer(fields[4], INT32_MIN, INT32_MAX, &record->wheels.left) &&
           integer(fields[5], INT32_MIN, INT32_MAX, &record->wheels.right);
  }
  record->kind = RecordKind::Done;
  return word == "done" && count == 4;
}

static string reply_again(char *payload) {
  const Fields fields(payload);
  const uint8_t count = fields.count();
  const string word = fields[0];
  LineWriter line;
  uint32_t job = 0, number = 0, clock = 0, sensors = 0, window = 0;
  int32_t value = 0;
  Record record;
  if (word == "hello" && count == 7 && read_natural(fields[4], 8, &sensors) && read_natural(fields[5], 255, &window)) {
    write_hello(line, fields[2], fields[3], sensors, window, fields[6]);
  } else if (word == "value" && count == 3 && is_name(fields[1]) && read_integer(fields[2], -9000, 9000, &value)) {
    write_value(line, fields[1], value);
  } else if (word == "pong" && count == 4 && read_natural(fields[1], 65535, &number) &&
             read_natural(fields[2], 65535, &job) && read_natural(fields[3], UINT32_MAX, &clock)) {
    write_pong(line, number, job, clock);
  } else if (word == "accepted" && count == 3 && read_natural(fields[2], 65535, &job)) {
    write_accepted(line, fields[1], job);
  } else if (word == "refused" && count == 3) {
    write_refused(line, fields[1], fields[2]);
  } else if (count >= 4 && read_natural(fields[1], 65535, &job) && read_natural(fields[2], UINT32_MAX, &number) &&
             read_natural(fields[3], UINT32_MAX, &record.clock) && read_record(word, fields, &record)) {
    write_record(line, job, number, record);
  } else {
    return "-";
  }
  return string(line.text(), line.length());
}

// What the code of the firmware makes of a line: the line as it would write it, or "-".
static string again(const string &sender, const string &text) {
  LineReader reader;
  bool is_line = false;
  for (const char byte : text) is_line = reader.feed(byte);
  is_line = reader.feed('\n') || is_line;
  if (!is_line) return "-";
  return sender == "host" ? command_again(reader.payload()) : reply_again(reader.payload());
}

static string expected(const string &payload) {
  if (payload == "-") return payload;
  std::ostringstream line;
  line << '$' << payload << '*' << std::uppercase << std::hex;
  line.width(8);
  line.fill('0');
  line << crc32(payload.data(), payload.size()) << '\n';
  return line.str();
}

int main(int, char **arguments) {
  std::ifstream file(arguments[1]);
  string row;
  std::getline(file, row);  // the heading
  int count = 0, wrong = 0;
  while (std::getline(file, row)) {
    const size_t first = row.find('\t'), second = row.find('\t', first + 1);
    const string sender = row.substr(0, first), payload = row.substr(first + 1, second - first - 1);
    string line = row.substr(second + 1);
    if (line.size() > 1 && line.substr(line.size() - 2) == "\\r") line.replace(line.size() - 2, 2, "\r");
    count++;
    if (again(sender, line) == expected(payload)) continue;
    wrong++;
    std::cout << "wrong: " << row << " -> " << again(sender, line) << '\n';
  }
  std::cout << count << " vectors\n";
  return wrong != 0;
}
