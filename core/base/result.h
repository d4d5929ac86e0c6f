#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace photond {

/// What kind of failure an Error reports; the server maps it to an HTTP status, the CLI to an exit code.
enum class ErrorCode {
  invalid_input,   ///< the caller's data breaks a rule (malformed file, setting out of range)
  unsupported,     ///< well-formed, but needs something photond does not implement
  limit_exceeded,  ///< well-formed, but larger than a stated limit
  not_found,       ///< a named thing (camera, file, job) does not exist
  conflict,        ///< the present state forbids the request
  io,              ///< the environment failed (file, socket, disk)
  cancelled,       ///< the caller's stop token was triggered
  internal         ///< our own mistake, reported rather than hidden
};

/// A failure caused by input, limits, environment or cancellation.
struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;  ///< one sentence for a person
  std::string where;    ///< place in the input (`/film/width`, `meshes[3].primitives[0]`); may be empty
};

/// Either a value or an Error.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : data_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : data_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return data_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { assert(ok()); return std::get<0>(data_); }
  const T& value() const& { assert(ok()); return std::get<0>(data_); }
  T&& value() && { assert(ok()); return std::get<0>(std::move(data_)); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }

  const Error& error() const { assert(!ok()); return std::get<1>(data_); }

 private:
  std::variant<T, Error> data_;
};

/// The value of a function that only succeeds or fails.
struct Done {};
using Status = Result<Done>;

inline Error invalid_input(std::string message, std::string where = {}) {
  return {ErrorCode::invalid_input, std::move(message), std::move(where)};
}
inline Error cancelled() { return {ErrorCode::cancelled, "cancelled", {}}; }

}  // namespace photond
