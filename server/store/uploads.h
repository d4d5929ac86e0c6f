#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/store/database.h"

namespace photond {

/// Whether `more` bytes fit into what `owner` may have uploaded, scenes and environment maps together; no limit: all.
/// Errors: limit_exceeded at "disk", io.
Status check_uploads(Transaction& transaction, const std::string& owner, std::uint64_t more,
                     const std::optional<std::uint64_t>& limit);

}  // namespace photond
