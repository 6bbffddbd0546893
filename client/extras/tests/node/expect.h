// Tests register themselves; the first expectation that fails ends the program.
#ifndef EXPECT_H_
#define EXPECT_H_

#include <stdio.h>
#include <stdlib.h>

#include <string>
#include <vector>

#include "bytes.h"

struct TestCase {
  const char* concept_name;
  const char* name;
  void (*run)();
};

std::vector<TestCase>& testCases();

struct Registration {
  Registration(const char* concept_name, const char* name, void (*run)()) {
    const TestCase test = {concept_name, name, run};
    testCases().push_back(test);
  }
};

#define TEST(concept_name, name)                                                            \
  static void concept_name##_##name();                                                      \
  static const Registration register_##concept_name##_##name(#concept_name, #name, &concept_name##_##name); \
  static void concept_name##_##name()

[[noreturn]] inline void failExpectation(const char* file, int line, const std::string& text) {
  fprintf(stderr, "%s:%d: %s\n", file, line, text.c_str());
  exit(1);
}

inline std::string show(const std::string& text) { return text; }
inline std::string show(const char* text) { return text; }
inline std::string show(double number) { return std::to_string(number); }
inline std::string show(int number) { return std::to_string(number); }
inline std::string show(unsigned number) { return std::to_string(number); }
inline std::string show(long number) { return std::to_string(number); }
inline std::string show(unsigned long number) { return std::to_string(number); }

template <class A, class B>
void expectEqual(const char* file, int line, const char* text, const A& got, const B& wanted) {
  if (got == wanted) return;
  failExpectation(file, line, std::string(text) + ": got " + show(got) + ", wanted " + show(wanted));
}

#define EXPECT(condition) \
  if (!(condition)) failExpectation(__FILE__, __LINE__, #condition)
#define EXPECT_EQUAL(got, wanted) expectEqual(__FILE__, __LINE__, #got, got, wanted)

#endif
