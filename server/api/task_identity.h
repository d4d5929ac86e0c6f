#pragma once

#include <string>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "core/render/render.h"
#include "server/api/json.h"

namespace photond {

/// Of the file that runs, which does not change: read when it is asked for first (10 ms). Errors: those of reading it.
const Result<Digest>& running_program();

/// What determines a picture, as JSON: build, scene, camera, settings and the plan's decisions. The build is the digest
/// of the running program, since another one may round differently. Errors: those of reading the program's file.
Result<Json> task_identity(const RenderTask& task);
/// The settings among them.
Json settings_json(const RenderTask& task);

/// The member in which two identities differ, such as "settings.seed"; empty where they are equal.
std::string first_difference(const Json& a, const Json& b);

}  // namespace photond
