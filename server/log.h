#pragma once

#include <concepts>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace photond {

enum class LogLevel : std::uint8_t { debug, info, warning, error, off };

/// Begins to write log lines of `level` and above to `file`, which must stay open until `end_log`. Lines are JSON
/// objects, written by a thread of their own: where nobody reads them fast enough the oldest are dropped and counted,
/// and nothing waits. Before `begin_log` and after `end_log` there is no log.
void begin_log(LogLevel level, std::FILE* file);
/// Writes what is left.
void end_log();
/// Lines that were dropped so far.
std::uint64_t lost_log_lines();

/// One line of the log: what happened and its particulars, written when the object goes. What a client sent in
/// headers or bodies does not belong here.
class LogLine {
 public:
  LogLine(LogLevel level, std::string_view event);
  ~LogLine();
  LogLine(const LogLine&) = delete;
  LogLine& operator=(const LogLine&) = delete;

  LogLine& with(std::string_view name, std::string_view text);
  LogLine& with(std::string_view name, double number);
  template <std::integral Number>
  LogLine& with(std::string_view name, Number number) {
    if constexpr (std::same_as<Number, bool>) return raw(name, number ? "true" : "false");
    return raw(name, std::to_string(number));
  }

 private:
  LogLine& raw(std::string_view name, std::string_view json);

  const LogLevel level_;
  const bool wanted_;
  std::string json_;
};

}  // namespace photond
