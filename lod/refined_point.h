// A point as OpenSubdiv's Far::PrimvarRefiner interpolates it.
#pragma once

#include <opensubdiv/far/primvarRefiner.h>

#include "base/vec.h"

namespace occam::lod {

struct RefinedPoint {
    Vec3d p{0};
    void Clear(void* = nullptr) { p = Vec3d(0); }
    void AddWithWeight(const RefinedPoint& other, float weight) { p += other.p * double(weight); }
};

}  // namespace occam::lod
