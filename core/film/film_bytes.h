#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/film/film.h"

namespace photond {

/// Takes the pieces of something written in order; its failure ends the writing.
using ByteSink = std::function<Status(std::span<const std::byte>)>;

/// A film as bytes, little-endian: width, height, the ranges of passes, rejected, and the sums. Equal films give
/// equal bytes. Errors: the sink's.
Status write_film(const Film& film, const ByteSink& sink);
/// How many bytes that are.
std::uint64_t film_size(const Film& film);
std::vector<std::byte> film_bytes(const Film& film);

/// The film of such bytes, which may be anything: nothing is allocated for sizes that the bytes do not have.
/// Errors: invalid_input.
Result<Film> read_film(std::span<const std::byte> bytes);

}  // namespace photond
