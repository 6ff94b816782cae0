// The motion of a placed cage that its nodes alone move: at each moment the cage is an affine image of one pose, its *still
// pose*.
//
// Such a cage needs no vertices at keys. It is diced once, in its still pose, and a ray is taken there by the inverse of the
// map of its own moment (docs/watertightness.md, rule 26). Between keys the elements of matrices are interpolated, which
// moves each vertex along the straight line between its places at the two keys.
//
// Space    maps lead from the dicing frame of the still pose to world axes.
// Threads  const after construction; it borrows its keys.
#pragma once

#include <optional>
#include <span>

#include "base/vec.h"
#include "lod/key_time.h"

namespace occam::lod {

/// Where the still pose is at one moment, or how fast it moves.
struct AffinePose {
    Vec3d columns[3];  ///< of the linear part
    Vec3d anchor;      ///< the place of the origin of the still pose's dicing frame, in the world

    /// Returns the image of a point, relative to the anchor.
    Vec3d apply(Vec3d p) const noexcept { return columns[0] * p.x + columns[1] * p.y + columns[2] * p.z; }
};

/// Takes vectors back through the linear part of a pose.
struct AffineInverse {
    Vec3d rows[3];  ///< cross products of the columns
    double scale;   ///< 1 / determinant

    explicit AffineInverse(const AffinePose& pose) noexcept
    {
        const Vec3d &a = pose.columns[0], &b = pose.columns[1], &c = pose.columns[2];
        rows[0] = glm::cross(b, c);
        rows[1] = glm::cross(c, a);
        rows[2] = glm::cross(a, b);
        scale = 1 / glm::dot(a, rows[0]);
    }
    Vec3d apply(Vec3d v) const noexcept
    {
        return Vec3d(glm::dot(rows[0], v) * scale, glm::dot(rows[1], v) * scale, glm::dot(rows[2], v) * scale);
    }
};

class AffineMotion {
public:
    explicit AffineMotion(std::span<const AffinePose> keys) noexcept;

    int segments() const noexcept { return static_cast<int>(keys_.size()) - 1; }
    const AffinePose& key(int k) const noexcept { return keys_[static_cast<std::size_t>(k)]; }
    /// Returns the pose at a moment of the shutter.
    AffinePose at(float tau) const noexcept;
    /// Returns how the pose changes at that moment, per shutter.
    AffinePose speed_at(float tau) const noexcept;
    /// Returns the inverse of the linear part at all moments, if this is the same at all keys: then only the anchor moves.
    const AffineInverse* fixed_inverse() const noexcept { return fixed_ ? &fixed_->inverse : nullptr; }
    /// Returns a bound on the factor by which a pose lengthens a vector.
    double stretch() const noexcept { return stretch_; }
    /// Returns whether every pose of the shutter, between keys too, has an inverse that rounding does not spoil: its
    /// determinant keeps its sign, and is at least 2^-10 of the product of the lengths of its columns.
    bool is_invertible() const noexcept;

private:
    std::span<const AffinePose> keys_;
    double stretch_ = 0;
    /// Of a motion that does not turn and keeps its size.
    struct Fixed {
        AffinePose pose;
        AffineInverse inverse;
    };
    std::optional<Fixed> fixed_;
};

}  // namespace occam::lod
