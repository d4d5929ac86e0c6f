#pragma once

#include "core/film/film.h"

namespace photond {

/// A film's picture and what is known of its error, per pixel and channel, in radiance and its square.
struct Reconstruction {
  ZeroedArray<glm::dvec3> mean;
  ZeroedArray<glm::dvec3> variance;   ///< of `mean` by what the bands add; the variance of the pass means is apart
  ZeroedArray<glm::dvec3> bias_sq;    ///< of `mean`: energy of all that is left out, less its noise: negative in places
};

/// The mean of the passes plus as much of each band as is signal. A band's energy in a window around the pixel,
/// less the variance that the photons themselves predict, is the bias that leaving the band out would cause; adding
/// it costs its variance. Adding the share a = 1 − λ·variance/energy of it is the best linear compromise for λ = 1
/// [Wiener]. A finer band is never added in a larger share than a coarser one, so that the picture is a mixture of
/// the estimates at the kScales radii with weights that are not negative. As passes are added the variance falls and
/// every band that holds signal is added whole: consistent. Once the execution is cancelled the result means nothing.
Reconstruction reconstruct(const Film& film, const Execution& execution = {});

/// The film's picture: reconstruct(film).mean. Once the execution is cancelled it means nothing.
Image film_picture(const Film& film, const Execution& execution = {});

}  // namespace photond
