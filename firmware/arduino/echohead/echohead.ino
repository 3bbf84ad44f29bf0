// Firmware of an ultrasonic head: sensors on a servo that speak the protocol of echoplan (docs/protocol.md).
// Set up your pins in config.h. For boards with an ATmega328P: Uno, Nano, Pro Mini.

#include <avr/sleep.h>

#include "config.h"
#include "protocol.h"
#include "records.h"
#include "sensors.h"
#include "servo.h"
#include "settings.h"
#include "sweep.h"
#include "wheels.h"

static_assert(F_CPU == 16000000L, "the servo is timed for a board with 16 MHz");

static const char FIRMWARE[] PROGMEM = "0.1.0";
static const char BOARD_NAME[] PROGMEM = BOARD;

static const char CAPABILITIES[] PROGMEM = ""
#if SERVO
    "-servo"
#endif
#if THERMOMETER
    "-air"
#endif
#if WHEELS
    "-wheels"
#endif
    ;

static LineReader reader;
static bool has_command = false;  // in the reader, to be obeyed when the line before is sent
static LineWriter line;
static uint8_t sent = 0;  // bytes of the line
static uint32_t sent_at;  // time of the last line [us]
static uint8_t listed = SETTINGS;  // settings that the answer to `config` has listed

static void greet() {
  const char *capabilities = sizeof CAPABILITIES > 1 ? CAPABILITIES + 1 : PSTR("none");
  write_hello(line, FIRMWARE, BOARD_NAME, SENSORS, records::MOST_UNACKNOWLEDGED, capabilities);
}

static void change_setting(const Command &command) {
  const Setting setting = settings::find(command.name);
  if (setting == SETTINGS) {
    write_refused(line, command.word, PSTR("unknown"));
  } else if (sweep::is_busy()) {
    write_refused(line, command.word, PSTR("busy"));
  } else if (!settings::set(setting, command.value)) {
    write_refused(line, command.word, PSTR("range"));
  } else {
    write_value(line, settings::name(setting), settings::get(setting));
  }
}

static void start_job(const Command &command) {
  const bool is_sweep = command.kind == CommandKind::Sweep;
  if (!is_sweep && !WHEELS) return write_refused(line, command.word, PSTR("unknown"));
  if (command.job != records::job()) {
    if (is_sweep && !sweep::is_reachable()) return write_refused(line, command.word, PSTR("range"));
    if (is_sweep) {
      sweep::start(command.job, command.argument);
    } else {
      sweep::start_move(command.job);
    }
  }
  write_accepted(line, command.word, command.job);
}

static void obey(const Command &command) {
  switch (command.kind) {
    case CommandKind::Damaged: break;
    case CommandKind::Hello: greet(); break;
    case CommandKind::Config: listed = 0; break;
    case CommandKind::Set: change_setting(command); break;
    case CommandKind::Ping: write_pong(line, command.job, records::job(), micros()); break;
    case CommandKind::Sweep:
    case CommandKind::Move: start_job(command); break;
    case CommandKind::Stop:
      sweep::stop(command.job);
      write_accepted(line, command.word, command.job);
      break;
    case CommandKind::Ack: records::acknowledge(command.job, command.argument); break;
  }
}

// Never more than the serial port can buffer: pings do not wait for it.
static void send() {
  for (int free = Serial.availableForWrite(); sent < line.length() && free > 0; free--) {
    Serial.write(line.text()[sent++]);
  }
  if (sent < line.length() || sent == 0) return;
  sent_at = micros();
  line.clear();
  sent = 0;
}

// Write the next line: first what is left of an answer, then an answer, then a record.
static void write_line() {
  if (listed < SETTINGS) {
    const Setting setting = (Setting)listed++;
    write_value(line, settings::name(setting), settings::get(setting));
  } else if (has_command) {
    obey(read_command(reader.payload()));
    has_command = false;
  } else {
    records::write_next(line, micros() - sent_at);
  }
}

// Sleep until the next interrupt: that of the clock comes within 1.024 ms.
static void sleep_if_idle() {
  const bool is_sending = line.length() > 0 && Serial.availableForWrite() > 0;
  if (sweep::is_waiting() && !is_sending && !has_command && listed == SETTINGS && !Serial.available()) sleep_mode();
}

void setup() {
  Serial.begin(115200);
  set_sleep_mode(SLEEP_MODE_IDLE);
  settings::begin();
  sensors::begin();
  servo::begin(settings::get(Zero));
  wheels::begin();
  greet();
}

void loop() {
  sweep::update();
  servo::update();
  // While a command waits, further bytes wait in the buffer of the serial port.
  while (!has_command && Serial.available()) has_command = reader.feed(Serial.read());
  send();
  if (line.length() == 0) write_line();
  sleep_if_idle();
}
