#pragma once

#include "core/render/render.h"

namespace photond {

/// Whether a coarse picture says something long before the first pass does: photons are gathered, and for many pixels.
bool has_preview(const RenderTask& task);

/// What is to be seen before the first pass is done: the same view from fewer pixels, about 1,936, enlarged to the
/// size of the film. It asks `maps` for the photon maps of the first pass, and takes no part in the film. A pure
/// function of the task. Errors: cancelled, those of `maps`.
Result<Image> render_preview(const RenderTask& task, const MapSource& maps, const Execution& execution);

}  // namespace photond
