#pragma once

#include <cstdint>

#include "core/trace/surface.h"

namespace photond {

// Light has three channels; glass that disperses (KHR_materials_dispersion) bends each by its index at one wavelength.
// Those three are the same for all that a pass traces, from the eye and from the lights, so that photons and paths meet
// in the same glass; other passes take others, and their mean is the spectrum.

/// The wavelengths, in nanometres, that stand for red, green and blue in a pass: distributed as linear sRGB sees an even
/// spectrum, without what lies outside its gamut, and spread evenly over consecutive passes.
Vec3 wavelengths_of_pass(std::uint64_t seed, std::uint32_t pass);

inline bool disperses(const Material& m) {
  return kAllFeatures && m.dispersion > 0 && m.ior > 1 && m.transmission > 0 && !m.thin_walled;
}

/// The material's index at a wavelength in nanometres, by Cauchy's two terms; Material::ior is that of the sodium line.
float index_at(const Material& material, float wavelength);

/// Lets light of several channels, which meets a surface that disperses, go on in one of them: chosen by u in [0, 1) in
/// proportion to what they carry, so that the sum stays the same and each channel does on average. `surface` becomes
/// that for its wavelength.
void disperse(SurfacePoint& surface, Rgb& light, const Vec3& wavelengths, float u);

}  // namespace photond
