#pragma once

#include <vector>

#include "server/api/api.h"
#include "server/http/route_table.h"

namespace photond {

/// All routes of the service; `api` must outlive them. Errors: internal where they are not those of the contract.
Result<std::vector<Route>> make_routes(Api& api);

}  // namespace photond
