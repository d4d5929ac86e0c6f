#pragma once

#include <string>

#include "server/api/message.h"

namespace photond {

/// `whole`, an answer 200 with the bytes of a file and a strong ETag, or the part of it that the request's Range names: 206, or 416
/// where nothing lies there. One range of bytes is served; several, or what cannot be read, get the whole, as RFC 9110
/// allows. With If-Range a part is served only where it names the ETag.
Response ranged(const Request& request, Response whole);

}  // namespace photond
