#pragma once

namespace photond {

/// The text of openapi.json, embedded by the build.
extern const char* const kOpenApiText;

}  // namespace photond
