#pragma once

#include <vector>

#include "server/api/api.h"
#include "server/http/route_table.h"

namespace photond {

/// All routes of the service; `api` must outlive them.
std::vector<Route> make_routes(Api& api);

}  // namespace photond
