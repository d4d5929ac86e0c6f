#pragma once

#include <optional>
#include <string>

#include "server/http/cors.h"
#include "server/http/head.h"

namespace photond {

/// Why a browser's request is not to be answered, if it is not: it changes something, and comes from a page of another
/// site that `cors` does not name; or, unless `any_host`, its Host is a name that anybody may have pointed at this
/// machine (DNS rebinding), whose pages the browser takes for the service's own. Names of this machine, addresses and
/// the names of the sites in `cors` are fine.
std::optional<std::string> refuse_origin(const Head& head, const Cors& cors, bool any_host);

}  // namespace photond
