// GW_CHECK(condition): a broken invariant of our own code. Always armed, also in release builds;
// prints what failed and aborts, so that the supervisor restarts the process.
// Never put data from a sensor, a file or a message under a GW_CHECK: reject it and count it.
#pragma once

#include <cstdio>
#include <cstdlib>

#define GW_CHECK(condition)                                                                     \
  do {                                                                                          \
    if (!(condition)) {                                                                         \
      std::fprintf(stderr, "<2>%s:%d: broken invariant: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                             \
    }                                                                                           \
  } while (false)
