#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/store/records.h"

namespace photond {

/// Records as text for the database, and back. A member that the text lacks keeps its default, so members may be
/// added without a migration; what the text has beyond them is ignored. Errors: io, for text that is none of ours.
std::string record_text(const JobRecord& job);  ///< without the series
Result<JobRecord> read_record(std::string_view text);
std::string event_text(const Event& event);
Result<Event> read_event(std::string_view text);
std::optional<std::string> error_text(const std::optional<ErrorEstimate>& error);
Result<std::optional<ErrorEstimate>> read_error(std::string_view text);

}  // namespace photond
