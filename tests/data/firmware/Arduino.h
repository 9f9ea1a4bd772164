/* A stand-in for Arduino's header: what the sketch of docs/howto/rules-on-a-microcontroller.md calls. */
#include <stdint.h>

enum { LOW, HIGH };
enum { INPUT, OUTPUT };
enum { A0 = 14, A1 };
#define constrain(value, low, high) ((value) < (low) ? (low) : ((value) > (high) ? (high) : (value)))

unsigned long micros();
int analogRead(uint8_t pin);
void analogWrite(uint8_t pin, int value);
void digitalWrite(uint8_t pin, uint8_t value);
void pinMode(uint8_t pin, uint8_t mode);
void setup();
void loop();
