#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <string>

namespace photond {

/// What an option admits.
template <class T>
struct Range {
  T least;
  T most;
};

/// Adds an option whose value is a whole number of this range, which its error names. (CLI11 would wrap a negative
/// number and cut one that is too large.)
template <class T>
CLI::Option* add_whole(CLI::App& app, const std::string& name, std::function<void(T)> set, Range<T> range,
                       const std::string& description);

/// Adds an option whose value is a number of this range, which its error names. An infinite range admits all numbers,
/// and those that are none, too: who uses them checks.
CLI::Option* add_number(CLI::App& app, const std::string& name, std::function<void(double)> set, Range<double> range,
                        const std::string& description);

}  // namespace photond
