#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/render/render.h"
#include "server/api/json.h"

namespace photond {

/// Some passes of a picture, and what determines the picture: accumulators of equal `identity` can be merged.
struct Accumulator {
  Json identity;
  Film film;
};

/// Build, scene, camera, settings and the plan's decisions. The build is the digest of the running program, since
/// another one may round differently. Errors: those of reading the program's file.
Result<Json> task_identity(const RenderTask& task);

/// The member in which two identities differ, such as "settings.seed"; empty where they are equal.
std::string first_difference(const Json& a, const Json& b);

/// The file: 8 bytes "photacc" and 0, its version and the length of the identity (32 bits each), the length of the
/// file (64 bits), the identity as JSON, the film (film_bytes), SHA-256 of all that. Little-endian.
std::vector<std::byte> accumulator_bytes(const Accumulator& accumulator);

/// Reads any bytes. Errors: invalid_input, saying whether the file is none, truncated, damaged or of another version.
Result<Accumulator> read_accumulator(std::span<const std::byte> bytes);

}  // namespace photond
