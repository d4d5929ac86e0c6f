#pragma once

#include <map>
#include <string>

#include "core/base/result.h"
#include "server/api/message.h"

namespace photond {

/// The web client's files, read once into memory: what is not in the table cannot be asked for, whatever the
/// path looks like.
class StaticFiles {
 public:
  StaticFiles() = default;
  /// All regular files under `folder`; links are not followed. Errors: io, limit_exceeded (64 MiB together).
  static Result<StaticFiles> load(const std::string& folder);

  /// The file at `path` ("/" is "/index.html", "/docs" is "/docs.html"), or null.
  const Response* find(const std::string& path) const;

 private:
  std::map<std::string, Response> files_;  ///< by path with a leading slash
};

}  // namespace photond
