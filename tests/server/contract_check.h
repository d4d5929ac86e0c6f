#pragma once

#include <string>

#include "tests/server/http_client.h"

namespace photond::test {

/// Expects the answer to be one that openapi.json announces for this request: its status, its type, its headers, and its
/// body where that is JSON.
void expect_contract_kept(const std::string& method, const std::string& target, const Reply& reply);

}  // namespace photond::test
