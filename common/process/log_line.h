// Log lines for people and journald: one line of key=value to stderr, with the priority in front.
//
//   <4>event=camera.lost count=3 action="check the USB cable" suppressed=12
//
// Nothing per image above kDebug, and every warning names what the operator can do.
#pragma once

#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "common/core/time.h"

namespace gw::process {

// Numbers of syslog(3), which journald reads from the `<N>` in front.
enum class Severity { kError = 3, kWarning = 4, kInfo = 6, kDebug = 7 };

class LogLine {
 public:
  using Field = std::pair<std::string_view, std::string>;
  using Sink = std::function<void(const std::string& line)>;  // the line ends with '\n'

  // At most one line about one event is written per min_interval; the next says how many were not.
  explicit LogLine(DurationUs min_interval = {1'000'000}, Sink sink = WriteToStderr)
      : min_interval_(min_interval), sink_(std::move(sink)) {}

  void Write(Utime now, Severity severity, const std::string& event,
             std::initializer_list<Field> fields = {});

 private:
  struct Past {
    Utime written;
    int64_t suppressed = 0;
  };
  static void WriteToStderr(const std::string& line);

  DurationUs min_interval_;
  Sink sink_;
  std::map<std::string, Past> past_;
};

}  // namespace gw::process
