// The handles of a scene. They are never pointers: a handle may outlive its object, and its use then reports this.
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
