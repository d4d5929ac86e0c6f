#include "server/log.h"

#include <spdlog/async_logger.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <atomic>
#include <charconv>
#include <cmath>
#include <memory>
#include <mutex>

namespace photond {

namespace {

constexpr std::size_t kQueuedLines = 8192;

class FileSink final : public spdlog::sinks::stdout_sink_base<spdlog::details::console_mutex> {
 public:
  using stdout_sink_base::stdout_sink_base;
};

/// The log of the process. Who writes a line holds it by a pointer: it may end meanwhile.
struct Log {
  Log(LogLevel least, std::FILE* file)
      : level(least),
        pool(std::make_shared<spdlog::details::thread_pool>(kQueuedLines, 1)),
        logger(std::make_shared<spdlog::async_logger>("photond", std::make_shared<FileSink>(file), pool,
                                                      spdlog::async_overflow_policy::overrun_oldest)) {
    logger->set_level(spdlog::level::trace);  // `level` has decided already
    logger->set_formatter(std::make_unique<spdlog::pattern_formatter>(
        R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})", spdlog::pattern_time_type::utc));
  }

  const LogLevel level;
  const std::shared_ptr<spdlog::details::thread_pool> pool;
  const std::shared_ptr<spdlog::async_logger> logger;
};

std::mutex g_mutex;
std::shared_ptr<const Log> g_log;
std::atomic<LogLevel> g_level{LogLevel::off};  // of g_log, to be asked without the mutex

std::shared_ptr<const Log> current_log() {
  const std::lock_guard lock(g_mutex);
  return g_log;
}

void replace_log(std::shared_ptr<const Log> log) {
  const std::lock_guard lock(g_mutex);
  g_level = log ? log->level : LogLevel::off;
  g_log.swap(log);
}

spdlog::level::level_enum spdlog_level(LogLevel level) {
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info, spdlog::level::warn,
                                                   spdlog::level::err, spdlog::level::off};
  return kLevels[static_cast<int>(level)];
}

/// `text` as a JSON string of ASCII: whatever came in, the line is valid. A byte beyond it stands as one character.
std::string quoted(std::string_view text) {
  std::string json = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') json += '\\';
    if (c >= 0x20 && c < 0x7f) {
      json += c;
      continue;
    }
    char escape[8];
    std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned char>(c));
    json += escape;
  }
  return json + '"';
}

}  // namespace

void begin_log(LogLevel level, std::FILE* file) { replace_log(std::make_shared<const Log>(level, file)); }

void end_log() { replace_log(nullptr); }

std::uint64_t lost_log_lines() {
  const auto log = current_log();
  return log ? log->pool->overrun_counter() : 0;
}

LogLine::LogLine(LogLevel level, std::string_view event) : level_(level), wanted_(level >= g_level.load()) {
  if (wanted_) json_ = "\"event\":" + quoted(event);
}

LogLine::~LogLine() {
  if (!wanted_) return;
  if (const auto log = current_log()) log->logger->log(spdlog_level(level_), json_);
}

LogLine& LogLine::with(std::string_view name, std::string_view text) { return wanted_ ? raw(name, quoted(text)) : *this; }

LogLine& LogLine::with(std::string_view name, double number) {
  if (!std::isfinite(number)) return raw(name, "null");
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, number);
  return raw(name, std::string_view(text, static_cast<std::size_t>(end - text)));
}

LogLine& LogLine::raw(std::string_view name, std::string_view json) {
  if (!wanted_) return *this;
  json_ += ',';
  json_ += quoted(name);
  json_ += ':';
  json_ += json;
  return *this;
}

}  // namespace photond
