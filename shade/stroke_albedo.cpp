#include "shade/stroke_albedo.h"

#include <algorithm>
#include <array>

#include "base/maths.h"
#include "base/simd.h"

namespace occam::shade {
namespace {

constexpr int kRings = 24, kAngles = 32;

// Visible normals come from the unit disc: rings that get finer towards its rim, where the long tail of GGX is. For x that
// is even over the rings, 1 - radius^2 is the cube of x, so a ring has the weight x^2.
struct Disc {
    std::array<float, kRings> weight, radius;
    float whole = 0;  // sum of the weights of all points
    alignas(32) float cosine[kAngles];
    alignas(32) float sine[kAngles];

    Disc() noexcept
    {
        for (int ring = 0; ring < kRings; ++ring) {
            const float x = (static_cast<float>(ring) + 0.5f) / kRings;
            weight[std::size_t(ring)] = x * x;
            radius[std::size_t(ring)] = std::sqrt(1 - x * x * x);
            whole += kAngles * (x * x);
        }
        for (int i = 0; i < kAngles; ++i) {
            const float angle = (static_cast<float>(i) + 0.5f) / kAngles * 2 * kPi;
            cosine[i] = maths::cos(angle);
            sine[i] = maths::sin(angle);
        }
    }
};

// Does for several angles of a ring what visible_normal_of() does for one point, and evaluates the layer there.
class Integrand {
public:
    struct Terms {
        vfloat f0, f90;
    };

    Integrand(Vec3f eye, Widths widths) noexcept : eye_(eye), widths_(widths)
    {
        const Vec3f stretched = widths.stretched(eye);
        length_ = glm::length(stretched);
        z_ = stretched / length_;
        const float flat = std::sqrt(z_.x * z_.x + z_.y * z_.y);
        x_ = flat > 0 ? Vec3f(-z_.y, z_.x, 0) / flat : Vec3f(1, 0, 0);
        y_ = glm::cross(z_, x_);
    }
    Terms at(vfloat p, vfloat q) const noexcept
    {
        const float s = 0.5f * (1 + z_.z);
        q = (1 - s) * sqrt(max(1.0f - p * p, vfloat(0.0f))) + s * q;
        const vfloat up = sqrt(max(1.0f - p * p - q * q, vfloat(0.0f)));
        const vfloat a = widths_.x * (x_.x * p + y_.x * q + z_.x * up), b = widths_.y * (x_.y * p + y_.y * q + z_.y * up),
                     c = max(y_.z * q + z_.z * up, vfloat(1e-6f));
        const vfloat inverse = 1.0f / sqrt(a * a + b * b + c * c), h_x = a * inverse, h_y = b * inverse, h_z = c * inverse;
        const vfloat v_h = eye_.x * h_x + eye_.y * h_y + eye_.z * h_z;
        const vfloat l_x = widths_.x * (2.0f * v_h * h_x - eye_.x), l_y = widths_.y * (2.0f * v_h * h_y - eye_.y),
                     n_l = 2.0f * v_h * h_z - eye_.z;
        // The weight is f cos / density = 4 n_l visibility / (G1 / n_v).
        const vfloat sum = eye_.z * sqrt(l_x * l_x + l_y * l_y + n_l * n_l) + n_l * length_;
        const vfloat weight = n_l * (eye_.z + length_) / max(sum, vfloat(1e-12f));
        const vfloat out = max(1.0f - v_h, vfloat(0.0f)), g = out * out * out * out * out;
        const vmask lit = (n_l > 0) & (v_h > 0);
        return {select(lit, weight * (1.0f - g), vfloat(0.0f)), select(lit, weight * g, vfloat(0.0f))};
    }

private:
    Vec3f eye_, x_, y_, z_;  // z_ is the eye, stretched
    float length_;
    Widths widths_;
};

}  // namespace

LayerAlbedo stroke_albedo(Vec3f eye, Widths widths) noexcept
{
    static const Disc disc;
    const Integrand integrand(eye, widths);
    // Each angle has a sum of its own, so that the number of lanes does not change the order of additions.
    alignas(32) float f0[kAngles], f90[kAngles];
    for (int i = 0; i < kAngles; i += kLanes) {
        Integrand::Terms sum{vfloat(0.0f), vfloat(0.0f)};
        const vfloat cosine = vfloat::load(disc.cosine + i), sine = vfloat::load(disc.sine + i);
        for (std::size_t ring = 0; ring < kRings; ++ring) {
            const auto [a, b] = integrand.at(disc.radius[ring] * cosine, disc.radius[ring] * sine);
            sum.f0 = sum.f0 + disc.weight[ring] * a;
            sum.f90 = sum.f90 + disc.weight[ring] * b;
        }
        sum.f0.store(f0 + i);
        sum.f90.store(f90 + i);
    }
    LayerAlbedo all{0, 0};
    for (int i = 0; i < kAngles; ++i) all.f0 += f0[i], all.f90 += f90[i];
    return {all.f0 / disc.whole, all.f90 / disc.whole};
}

}  // namespace occam::shade
