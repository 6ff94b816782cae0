// The importer of glTF 2.0 and GLB, with the extensions of the material model, punctual lights and the cages of
// extras.occam.
#pragma once

#include "io/import/import.h"

namespace occam::import {

Scene load_gltf(const std::filesystem::path& file, const LoadOptions& options);

}  // namespace occam::import
