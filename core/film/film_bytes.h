#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/film/film.h"

namespace photond {

/// A film as bytes, little-endian: width, height, the ranges of passes, rejected, and the sums. Equal films give
/// equal bytes.
std::vector<std::byte> film_bytes(const Film& film);

/// The film of such bytes, which may be anything: nothing is allocated for sizes that the bytes do not have.
/// Errors: invalid_input.
Result<Film> read_film(std::span<const std::byte> bytes);

}  // namespace photond
