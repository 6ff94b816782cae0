// Loading of a glTF or GLB file, checked and parsed: from here on its model holds no index out of range.
#pragma once

#include <tiny_gltf.h>

#include "io/import/report.h"

namespace occam::import {

/// Checks the container and the JSON (gltf_door.h), then lets tinygltf read them. Buffers are resolved; data URIs of images
/// are in Image::image, undecoded; images in files or buffer views are left where they are. Throws Error naming the element.
tinygltf::Model open_gltf(Report& report);

}  // namespace occam::import
