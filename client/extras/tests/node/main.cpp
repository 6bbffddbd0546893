// Runs the tests of the concepts that are its arguments; without arguments, all tests.
#include <string.h>

#include "expect.h"

std::vector<TestCase>& testCases() {
  static std::vector<TestCase> cases;
  return cases;
}

static bool isWanted(const TestCase& test, int count, char** names) {
  for (int i = 1; i < count; ++i) {
    if (strcmp(names[i], test.concept_name) == 0) return true;
  }
  return count == 1;
}

int main(int count, char** names) {
  int run = 0;
  for (size_t i = 0; i < testCases().size(); ++i) {
    const TestCase& test = testCases()[i];
    if (!isWanted(test, count, names)) continue;
    fprintf(stderr, "%s: %s\n", test.concept_name, test.name);
    try {
      test.run();
    } catch (const char* what) {
      failExpectation(__FILE__, __LINE__, what);
    }
    ++run;
  }
  if (run == 0) fprintf(stderr, "no such tests\n");
  return run == 0;
}
