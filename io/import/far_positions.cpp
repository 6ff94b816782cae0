#include "io/import/far_positions.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace occam::import {

namespace {

constexpr double kLostPart = 1.0 / (1 << 20);
constexpr double kRounding = 1.0 / (1 << 24);  // at most, of a coordinate in a float

double largest_part(Vec3d v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

void FarPositions::add(Vec3d position)
{
    if (!is_kept_) return;
    all_.push_back(position);
    const double reach = largest_part(position);
    if (!(reach <= double(kMaxCoordinate))) return;
    box_.add(position);
    loss_ = std::max(loss_, largest_part(position - Vec3d(Vec3f(position))));
    // No coordinate is farther from the origin than this one and the box's side together. As the side only grows, what
    // cannot be lost now cannot be lost later.
    const double side = largest_part(box_.hi - box_.lo);
    if ((reach + side) * kRounding <= side * kLostPart) drop();
}

bool FarPositions::loses_shape() const noexcept
{
    return is_kept_ && loss_ > 0 && loss_ > largest_part(box_.hi - box_.lo) * kLostPart;
}

Vec3d FarPositions::move(std::vector<Vec3f>& positions)
{
    const bool moves = loses_shape() && all_.size() == positions.size();
    const std::vector<Vec3d> all = std::exchange(all_, {});
    is_kept_ = false;
    if (!moves) return Vec3d(0);
    const Vec3d middle = 0.5 * (box_.lo + box_.hi);
    for (std::size_t i = 0; i < all.size(); ++i) positions[i] = Vec3f(all[i] - middle);
    return middle;
}

}  // namespace occam::import
