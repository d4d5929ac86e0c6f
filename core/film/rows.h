#pragma once

#include "core/film/film.h"

namespace photond {

/// Calls body(y) for all rows of the film, in parallel; after cancellation the remaining ones are skipped.
template <class Body>
void for_rows(const Film& film, const Execution& execution, const Body& body) {
  constexpr std::size_t kGrain = 16;
  parallel_for(execution, static_cast<std::size_t>(film.height), kGrain, body);
}

/// Calls body(i) for all pixels of the film, row by row as for_rows does.
template <class Body>
void for_pixels(const Film& film, const Execution& execution, const Body& body) {
  const auto width = static_cast<std::size_t>(film.width);
  for_rows(film, execution, [&](std::size_t y) {
    for (std::size_t i = y * width; i < (y + 1) * width; ++i) body(i);
  });
}

}  // namespace photond
