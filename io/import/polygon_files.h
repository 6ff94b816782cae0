// The importers of PLY (ASCII and binary), OFF and STL: small readers of our own, which never allocate more than the file
// has bytes for.
#pragma once

#include "io/import/import.h"
#include "io/import/polygons.h"
#include "io/import/report.h"

namespace occam::import {

Scene load_ply(const std::filesystem::path& file, const LoadOptions& options);
Scene load_off(const std::filesystem::path& file, const LoadOptions& options);
Scene load_stl(const std::filesystem::path& file, const LoadOptions& options);

/// Makes a scene of one node that shows `polygons`.
Scene scene_of(Polygons polygons, const LoadOptions& options, Report& report);

}  // namespace occam::import
