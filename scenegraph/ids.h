// The handles of a scene. Never pointers: a handle outlives what it names, and says so when it is used.
#pragma once

#include "base/handle.h"

namespace occam {

using NodeId = Handle<struct NodeTag>;
using CageId = Handle<struct CageTag>;
using MaterialId = Handle<struct MaterialTag>;
using TextureId = Handle<struct TextureTag>;
using LightId = Handle<struct LightTag>;
using CameraId = Handle<struct CameraTag>;
using SkinId = Handle<struct SkinTag>;
using ClipId = Handle<struct ClipTag>;

}  // namespace occam
