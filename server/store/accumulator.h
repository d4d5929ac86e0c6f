#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/film/film.h"
#include "core/film/film_bytes.h"

namespace photond {

/// Some passes of a picture, and what determines the picture: accumulators of equal `identity` can be merged. To this
/// code the identity is any text; see api/task_identity.h.
struct Accumulator {
  std::string identity;
  Film film;
};

/// The file: 8 bytes "photacc" and 0, its version and the length of the identity (32 bits each), the length of the
/// file (64 bits), the identity, the film (film_bytes), SHA-256 of all that. Little-endian. Errors: the sink's.
Status write_accumulator(const std::string& identity, const Film& film, const ByteSink& sink);
std::vector<std::byte> accumulator_bytes(const Accumulator& accumulator);

/// Reads any bytes. Errors: invalid_input, saying whether the file is none, truncated, damaged or of another version.
Result<Accumulator> read_accumulator(std::span<const std::byte> bytes);

}  // namespace photond
