// What is connected to the board, and the settings after a reset. Edit this file before you flash.
// Each line is read by scripts too: the wiring diagram in the documents comes from here.
#pragma once

#define BOARD "uno"  // letters, digits, '.', '_' and '-'

// Ultrasonic sensors with a trigger and an echo pin: HC-SR04 and alike.
#define SENSORS 4                     // 1 to 4
#define TRIGGER_PINS 2, 3, 4, 5       // any digital pins, one for each sensor
#define ECHO_PINS A0, A1, A2, A3      // of A0 to A5, one for each sensor

// Servo under the sensors.
#define SERVO 1      // 0: none
#define SERVO_PIN 9  // the output of Timer1: no other pin

// Analogue thermometer: TMP36 (500 mV at 0 degrees Celsius, 10 mV per degree).
#define THERMOMETER 0  // 1: connected
#define THERMOMETER_PIN A4
#define SUPPLY_MILLIVOLTS 5000  // measure it at the 5V pin: 1 % is 2 degrees

// Wheel encoders.
#define WHEELS 0               // 0: none, 1: one channel (counts forwards only), 2: quadrature
#define LEFT_WHEEL_PINS 6, 7   // channels A and B, of D0 to D7
#define RIGHT_WHEEL_PINS 10, 11  // channels A and B, of D8 to D13

// Settings after a reset; docs/protocol.md explains them.
#define DEFAULT_START -4500
#define DEFAULT_STOP 4500
#define DEFAULT_STEP 100
#define DEFAULT_ZERO 1500
#define DEFAULT_GAIN 1000
#define DEFAULT_DWELL 25
#define DEFAULT_GUARD 25
#define DEFAULT_TOGETHER 0
#define DEFAULT_SETTLE 500
#define DEFAULT_LISTEN 25
#define DEFAULT_TICK 0  // way of a wheel from count to count [um]
#define DEFAULT_BASE 0  // distance between the wheels [0.1 mm]
#define DEFAULT_WINDOW 0
