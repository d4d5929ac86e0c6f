#pragma once

#include <string>

#include "server/api/json.h"
#include "server/store/records.h"

namespace photond {

/// Reads the message of POST /v1/jobs, which keeps the schema JobSpec of the contract. Errors: invalid_input for what no
/// schema says (a camera that looks nowhere), with the JSON pointer of the field.
Result<JobSpec> parse_job(const Json& message);
/// The member `stop` of such a message, or its default.
StopRule parse_stop(const Json& message);

/// A job as clients see it.
Json job_message(const JobRecord& job);
Json plan_message(const Plan& plan);
/// null where nothing is known yet
Json error_message(const ErrorEstimate& error);
Json spec_message(const JobSpec& spec);
Json event_message(const Event& event);
Json series_message(const JobRecord& job);

const char* event_name(EventKind kind);  ///< "state", "progress", "frame", "gone"

}  // namespace photond
