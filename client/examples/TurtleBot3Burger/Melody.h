// Melodies on the OpenCR's buzzer, without waiting for their end.
#ifndef MELODY_H
#define MELODY_H

#include <Arduino.h>
#include <turtlebot3_msgs/Sound.h>

struct Note {
  uint16_t hertz;  // 0: a pause
  uint16_t length_ms;
};

const Note NOTES_ON[] = {{262, 250}, {294, 250}, {330, 250}, {349, 250}, {392, 250}, {440, 250}, {494, 250}, {523, 250}};
const Note NOTES_OFF[] = {{523, 250}, {494, 250}, {440, 250}, {392, 250}, {349, 250}, {330, 250}, {294, 250}, {262, 250}};
const Note NOTES_LOW_BATTERY[] = {{1000, 900}, {0, 100}, {1000, 900}, {0, 100}, {1000, 900}, {0, 100}, {1000, 900}};
const Note NOTES_ERROR[] = {{1000, 300}, {500, 300}, {1000, 300}, {500, 300}, {1000, 300}, {500, 300}};
const Note NOTES_BUTTON[] = {{880, 100}};

class Melody {
 public:
  void play(uint8_t sound) {
    switch (sound) {
      case turtlebot3_msgs::Sound::OFF: start(NOTES_OFF); break;
      case turtlebot3_msgs::Sound::ON: start(NOTES_ON); break;
      case turtlebot3_msgs::Sound::LOW_BATTERY: start(NOTES_LOW_BATTERY); break;
      case turtlebot3_msgs::Sound::ERROR: start(NOTES_ERROR); break;
      default: start(NOTES_BUTTON);
    }
  }

  // Call it often.
  void update() {
    if (left_ == 0 || millis() - began_ms_ < length_ms_) return;
    began_ms_ = millis();
    length_ms_ = note_->length_ms;
    if (note_->hertz) {
      tone(BDPIN_BUZZER, note_->hertz, note_->length_ms);
    } else {
      noTone(BDPIN_BUZZER);
    }
    ++note_;
    --left_;
  }

 private:
  template <size_t COUNT>
  void start(const Note (&notes)[COUNT]) {
    note_ = notes;
    left_ = COUNT;
    length_ms_ = 0;
  }

  const Note* note_ = NULL;
  uint8_t left_ = 0;
  uint32_t began_ms_ = 0;
  uint16_t length_ms_ = 0;
};

#endif
