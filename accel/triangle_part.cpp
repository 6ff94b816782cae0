#include "accel/triangle_part.h"

#include <cfloat>

namespace occam::accel {
namespace {

// Rounds a box outward, by more than the errors in double.
Box3f outward(const Box3d& box) noexcept
{
    const Vec3f lo(box.lo), hi(box.hi);
    return {lo - glm::abs(lo) * FLT_EPSILON, hi + glm::abs(hi) * FLT_EPSILON};
}

}  // namespace

TrianglePart::TrianglePart(const Vec3f* corners) noexcept
{
    for (int p = 0; p < 3; ++p) {
        triangle_[p] = Vec3d(corners[p]);
        corners_[p] = {triangle_[p], Vec3d(p == 0, p == 1, p == 2)};
    }
}

void TrianglePart::cut(int axis, double plane, double sign) noexcept
{
    bool is_all_in = true;
    for (int i = 0; i < count_; ++i) is_all_in = is_all_in && sign * (corners_[i].at[axis] - plane) >= 0;
    if (is_all_in) return;
    Corner kept[kMost];
    int n = 0;
    for (int i = 0; i < count_; ++i) {
        const Corner &a = corners_[i], &b = corners_[i + 1 < count_ ? i + 1 : 0];
        const double a_in = sign * (a.at[axis] - plane), b_in = sign * (b.at[axis] - plane);
        if (a_in >= 0 && n < kMost) kept[n++] = a;
        if (!((a_in > 0 && b_in < 0) || (a_in < 0 && b_in > 0)) || n == kMost) continue;
        Corner& cut = kept[n++];
        cut.share = a.share + (b.share - a.share) * (a_in / (a_in - b_in));
        cut.at = triangle_[0] * cut.share.x + triangle_[1] * cut.share.y + triangle_[2] * cut.share.z;
        cut.at[axis] = plane;
    }
    count_ = n;
    for (int i = 0; i < n; ++i) corners_[i] = kept[i];
}

void TrianglePart::cut_to(const Box3f& box) noexcept
{
    for (int a = 0; a < 3; ++a) {
        cut_below(a, box.lo[a]);
        cut_above(a, box.hi[a]);
    }
}

Box3f TrianglePart::box() const noexcept
{
    Box3d box;
    for (int i = 0; i < count_; ++i) box.add(corners_[i].at);
    return count_ == 0 ? Box3f() : outward(box);
}

Box3f TrianglePart::box_at(const Vec3f* corners) const noexcept
{
    Box3d box;
    for (int i = 0; i < count_; ++i) {
        const Vec3d& share = corners_[i].share;
        box.add(Vec3d(corners[0]) * share.x + Vec3d(corners[1]) * share.y + Vec3d(corners[2]) * share.z);
    }
    return count_ == 0 ? Box3f() : outward(box);
}

}  // namespace occam::accel
