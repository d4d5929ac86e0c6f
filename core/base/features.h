#pragma once

namespace photond {

/// What scenes may have beyond Lambert surfaces of one colour and lamps, all of it compiled in. Only the program that
/// `./run bench features` compares with is built without: there every test for such a feature is false at compile time.
#ifdef PHOTOND_LAMBERT_ONLY
inline constexpr bool kAllFeatures = false;
#else
inline constexpr bool kAllFeatures = true;
#endif

}  // namespace photond
