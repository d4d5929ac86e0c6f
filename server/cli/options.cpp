#include "server/cli/options.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

namespace photond {
namespace {

/// The number that is all of `text`.
template <class T>
std::optional<T> parse(const std::string& text) {
  T number{};
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || last != end) return std::nullopt;
  return number;
}

std::string text_of(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

}  // namespace

template <class T>
CLI::Option* add_whole(CLI::App& app, const std::string& name, std::function<void(T)> set, Range<T> range,
                       const std::string& description) {
  const auto take = [name, set = std::move(set), range](const std::string& text) {
    const std::optional<T> number = parse<T>(text);
    if (!number || *number < range.least || *number > range.most) {
      throw CLI::ValidationError(name, "expects a whole number from " + std::to_string(range.least) + " to " +
                                           std::to_string(range.most));
    }
    set(*number);
  };
  return app.add_option_function<std::string>(name, take, description)->type_name("N");
}

template CLI::Option* add_whole(CLI::App&, const std::string&, std::function<void(int)>, Range<int>,
                                const std::string&);
template CLI::Option* add_whole(CLI::App&, const std::string&, std::function<void(std::uint32_t)>,
                                Range<std::uint32_t>, const std::string&);
template CLI::Option* add_whole(CLI::App&, const std::string&, std::function<void(std::uint64_t)>,
                                Range<std::uint64_t>, const std::string&);

CLI::Option* add_number(CLI::App& app, const std::string& name, std::function<void(double)> set, Range<double> range,
                        const std::string& description) {
  const bool bounded = std::isfinite(range.most);
  const auto take = [name, set = std::move(set), range, bounded](const std::string& text) {
    const std::optional<double> number = parse<double>(text);
    if (!number || (bounded && !(*number >= range.least && *number <= range.most))) {
      const std::string words = bounded ? " from " + text_of(range.least) + " to " + text_of(range.most) : "";
      throw CLI::ValidationError(name, "expects a number" + words);
    }
    set(*number);
  };
  return app.add_option_function<std::string>(name, take, description)->type_name("X");
}

}  // namespace photond
