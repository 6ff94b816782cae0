// The importer of Wavefront OBJ: it makes one cage of the whole file, so that what its groups share stays shared.
#pragma once

#include "io/import/import.h"
#include "io/import/polygons.h"
#include "io/import/report.h"

namespace occam::import {

/// Reads polygons, subdivision tags and, if asked for, the materials of MTL files, which are added to `scene` and become the
/// slots of the cage. Throws Error if the file cannot be read or has no face.
Polygons read_obj(const std::filesystem::path& file, Scene& scene, bool with_materials, Report& report);

Scene load_obj(const std::filesystem::path& file, const LoadOptions& options);

}  // namespace occam::import
