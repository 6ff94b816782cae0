#include "shade/albedo_table.h"

#include <algorithm>
#include <cmath>

#include "base/simd.h"
#include "shade/microfacet.h"

namespace occam::shade {
namespace {

constexpr int kRings = 24, kAngles = 12, kPoints = kRings * kAngles;

// With visible normals, only the masking of the integrand is left. The normals come from the unit disc: rings that get
// finer towards its rim, where the long tail of GGX is, and half a turn of angles (the other half is its mirror image).
struct Disc {
    float x[kPoints], y[kPoints], height[kPoints];  // of the points, and of the sphere's half above them, at y = 0
    double area[kPoints];                           // weight of a point
    double whole = 0;

    Disc() noexcept
    {
        for (int ring = 0; ring < kRings; ++ring) {
            const float root = (static_cast<float>(ring) + 0.5f) / kRings;
            const float radius = std::sqrt(1 - root * root * root);
            whole += double(root) * double(root) * kAngles;  // because 1 - radius^2 is the cube of the root
            for (int i = 0; i < kAngles; ++i) {
                // The disc's second axis lies in the plane of the eye, so the mirror images differ in the sign of the first
                // one.
                const float angle = (static_cast<float>(i) + 0.5f) / kAngles * kPi - kPi / 2;
                const int point = ring * kAngles + i;
                x[point] = radius * maths::cos(angle);
                y[point] = radius * maths::sin(angle);
                height[point] = std::sqrt(std::max(0.0f, 1 - x[point] * x[point]));
                area[point] = double(root) * double(root);
            }
        }
    }
};

// The first loop does what visible_normal_of() does, in lanes.
LayerAlbedo integrate(const Disc& disc, float cosine, float alpha) noexcept
{
    const Vec3f eye(std::sqrt(std::max(0.0f, 1 - cosine * cosine)), 0, cosine);
    const Vec3f z = glm::normalize(Vec3f(alpha * eye.x, 0, eye.z));
    const float across = std::sqrt(z.x * z.x);  // of the eye, stretched
    const Vec3f x = z.x * z.x > 0 ? Vec3f(0, z.x, 0) / across : Vec3f(1, 0, 0), y = glm::cross(z, x);
    const float s = 0.5f * (1 + z.z);
    const float masking = ggx_masking_over_cosine(cosine, alpha), root_v = ggx_root(cosine, alpha), a2 = alpha * alpha;
    float v_h[kPoints], n_l[kPoints], weight[kPoints];
    for (int i = 0; i < kPoints; i += kLanes) {
        const vfloat p = vfloat::load(disc.x + i),
                     q = (1 - s) * vfloat::load(disc.height + i) + s * vfloat::load(disc.y + i);
        const vfloat up = sqrt(max(vfloat(1.0f) - p * p - q * q, vfloat(0.0f)));
        const vfloat a = alpha * (x.x * p + y.x * q + z.x * up), b = alpha * (x.y * p + y.y * q + z.y * up),
                     c = max(x.z * p + y.z * q + z.z * up, vfloat(1e-6f));
        const vfloat inverse = vfloat(1.0f) / sqrt(a * a + b * b + c * c), h_x = a * inverse, h_z = c * inverse;
        const vfloat v = eye.x * h_x + eye.z * h_z, n = 2 * v * h_z - eye.z;
        const vfloat sum = cosine * sqrt(n * n * (1 - a2) + a2) + n * root_v;
        // The weight is f cos / density = 4 n_l visibility / (G1 / n_v).
        const vfloat w = 4 * n * (0.5f / max(sum, vfloat(1e-12f))) / masking;
        v.store(v_h + i);
        n.store(n_l + i);
        w.store(weight + i);
    }
    double f0 = 0, f90 = 0;
    for (int i = 0; i < kPoints; ++i) {
        if (!(n_l[i] > 0) || !(v_h[i] > 0)) continue;
        const double out = std::max(0.0, 1 - double(v_h[i])), g = out * out * out * out * out;
        f0 += disc.area[i] * double(weight[i]) * (1 - g);
        f90 += disc.area[i] * double(weight[i]) * g;
    }
    return {static_cast<float>(f0 / disc.whole), static_cast<float>(f90 / disc.whole)};
}

LayerAlbedo mix(LayerAlbedo a, LayerAlbedo b, float share) noexcept
{
    return {a.f0 + (b.f0 - a.f0) * share, a.f90 + (b.f90 - a.f90) * share};
}

// Scales down an albedo above 1, which is a rounding error.
LayerAlbedo at_most_one(LayerAlbedo e) noexcept
{
    const float sum = e.sum();
    return sum > 1 ? LayerAlbedo{e.f0 / sum, e.f90 / sum} : e;
}

float lack(LayerAlbedo e) noexcept { return std::max(0.0f, 1 - e.sum()); }

// What an albedo lacks between two nodes: it is linear in the number y of the node.
struct Lack {
    double node, first, slope;

    Lack(std::size_t below, float at_node, float at_next) noexcept
        : node(static_cast<double>(below)), first(double(at_node)), slope(double(at_next) - double(at_node))
    {
    }
    double at(double y) const noexcept { return first + slope * (y - node); }
    // Returns the integral of it times y cubed from the node on.
    double sum_to(double y) const noexcept
    {
        const double y4 = y * y * y * y, n4 = node * node * node * node;
        return (first - slope * node) * (y4 - n4) / 4 + slope * (y4 * y - n4 * node) / 5;
    }
    // Returns the place up to which the integral is a part of that up to the next node.
    double place_of(double part) const noexcept
    {
        const double n4 = node * node * node * node, next = node + 1, all = sum_to(next);
        double low = node, high = next;
        part = std::clamp(part, 0.0, std::max(all, 0.0));
        double y = all > 0 ? std::sqrt(std::sqrt(n4 + part / all * (next * next * next * next - n4))) : node;
        y = std::clamp(y, node, next);
        for (int i = 0; i < 8; ++i) {
            const double excess = sum_to(y) - part;
            (excess > 0 ? high : low) = y;
            const double newton = y - excess / (at(y) * y * y * y);
            y = newton >= low && newton <= high ? newton : (low + high) / 2;
        }
        return y;
    }
};

float row_root(float alpha) noexcept { return std::sqrt(std::sqrt(std::max(0.0f, alpha))); }
const float kLeastRoot = row_root(kMinAlpha);

template <class Row>
LayerAlbedo in_row(const Row& row, float root_of_cosine) noexcept
{
    const TablePlace p = table_place(root_of_cosine, static_cast<int>(row.size()));
    const auto i = static_cast<std::size_t>(p.below);
    return mix(row[i], row[i + 1], p.share);
}

}  // namespace

AlbedoTable& AlbedoTable::table() noexcept
{
    static AlbedoTable table;
    return table;
}

AlbedoTable::Row AlbedoTable::row_of(float alpha) noexcept
{
    const Row row = table_place((row_root(alpha) - kLeastRoot) / (1 - kLeastRoot), kRoughnesses);
    table().make_beside(static_cast<std::size_t>(row.below));
    return row;
}

namespace {

// Does what table_place() does.
AlbedoTable::RowLanes places_of(vfloat x, int nodes) noexcept
{
    alignas(32) float at[kLanes], below[kLanes];
    const vfloat zero = 0.0f;
    (select(x > zero, min(x, vfloat(1.0f)), zero) * static_cast<float>(nodes - 1)).store(at);
    AlbedoTable::RowLanes places;
    for (int i = 0; i < kLanes; ++i) {
        const int node = std::min(static_cast<int>(at[i]), nodes - 2);
        places.below[i] = static_cast<std::size_t>(node);
        below[i] = static_cast<float>(node);
    }
    places.share = vfloat::load(at) - vfloat::load(below);
    return places;
}

// Mixes two neighbours, the first of which node(lane) returns.
template <class Node>
LayerAlbedoOf<vfloat> mix_neighbours(Node&& node, vfloat share) noexcept
{
    static_assert(sizeof(LayerAlbedo) == 2 * sizeof(float));
    const float* from[kLanes];
    for (int i = 0; i < kLanes; ++i) from[i] = &node(i)->f0;
    vfloat of[4];  // both factors of the first node, and those of the second
    load_turned(from, of);
    return {of[0] + (of[2] - of[0]) * share, of[1] + (of[3] - of[1]) * share};
}

}  // namespace

AlbedoTable::RowLanes AlbedoTable::row_of(vfloat alpha) noexcept
{
    const RowLanes rows = places_of((sqrt(sqrt(max(alpha, vfloat(0.0f)))) - kLeastRoot) / (1 - kLeastRoot), kRoughnesses);
    AlbedoTable& all = table();
    for (const std::size_t below : rows.below) all.make_beside(below);
    return rows;
}

LayerAlbedoOf<vfloat> AlbedoTable::at(vfloat cosine, const RowLanes& r) const noexcept
{
    const RowLanes c = places_of(sqrt(max(cosine, vfloat(0.0f))), kCosines);
    const auto in = [&](std::size_t above) {
        return mix_neighbours([&](int i) { return &rows_[r.below[i] + above][c.below[i]]; }, c.share);
    };
    const LayerAlbedoOf<vfloat> a = in(0), b = in(1);
    return {a.f0 + (b.f0 - a.f0) * r.share, a.f90 + (b.f90 - a.f90) * r.share};
}

LayerAlbedoOf<vfloat> AlbedoTable::mean(const RowLanes& r) const noexcept
{
    return mix_neighbours([&](int i) { return &means_[r.below[i]]; }, r.share);
}

void AlbedoTable::make(std::size_t r) noexcept
{
    static const Disc disc;
    const std::lock_guard lock(making_);
    if (is_made_[r].load(std::memory_order_relaxed)) return;
    const float root = kLeastRoot + (1 - kLeastRoot) * static_cast<float>(r) / (kRoughnesses - 1);
    const float alpha = root * root * root * root;
    auto& row = rows_[r];
    for (int c = 0; c < kCosines; ++c) {
        const float root_of_cosine = std::max(static_cast<float>(c), 0.05f) / (kCosines - 1);
        row[static_cast<std::size_t>(c)] = at_most_one(integrate(disc, root_of_cosine * root_of_cosine, alpha));
    }
    lost_below_[r][0] = 0;
    for (std::size_t c = 0; c + 1 < row.size(); ++c)
        lost_below_[r][c + 1] = lost_below_[r][c] +
                                Lack(c, lack(row[c]), lack(row[c + 1])).sum_to(static_cast<double>(c + 1));
    // The mean is that of the interpolated row, so that lobes made of both neither lose nor gain light.
    double f0 = 0, f90 = 0;
    constexpr int kSteps = 16 * (kCosines - 1);
    for (int i = 0; i < kSteps; ++i) {
        const double of_cosine = (i + 0.5) / kSteps;
        const LayerAlbedo e = in_row(row, static_cast<float>(of_cosine));
        const double weight = 4 * of_cosine * of_cosine * of_cosine / kSteps;  // 2 cos d(cos), cos = root^2
        f0 += weight * double(e.f0);
        f90 += weight * double(e.f90);
    }
    means_[r] = {static_cast<float>(f0), static_cast<float>(f90)};
    constexpr double kNodes = kCosines - 1;
    lost_[r] = static_cast<float>(4 / (kNodes * kNodes * kNodes * kNodes) * lost_below_[r].back());
    is_made_[r].store(true, std::memory_order_release);
}

LayerAlbedo AlbedoTable::at(float cosine, Row r) const noexcept
{
    const float root = std::sqrt(std::max(0.0f, cosine));
    const auto i = static_cast<std::size_t>(r.below);
    return mix(in_row(rows_[i], root), in_row(rows_[i + 1], root), r.share);
}

LayerAlbedo AlbedoTable::mean(Row r) const noexcept
{
    const auto i = static_cast<std::size_t>(r.below);
    return mix(means_[i], means_[i + 1], r.share);
}

float AlbedoTable::lost(Row r) const noexcept
{
    const auto i = static_cast<std::size_t>(r.below);
    return lost_[i] + (lost_[i + 1] - lost_[i]) * r.share;
}

vfloat AlbedoTable::lost(const RowLanes& r) const noexcept
{
    alignas(32) float below[kLanes], above[kLanes];
    for (int i = 0; i < kLanes; ++i) {
        below[i] = lost_[r.below[i]];
        above[i] = lost_[r.below[i] + 1];
    }
    const vfloat from = vfloat::load(below);
    return from + (vfloat::load(above) - from) * r.share;
}

float AlbedoTable::draw_lost(float number, Row r) const noexcept
{
    const auto row = static_cast<std::size_t>(r.below);
    const auto sum_below = [&](std::size_t node) {
        const double sum = lost_below_[row][node];
        return sum + (lost_below_[row + 1][node] - sum) * double(r.share);
    };
    const auto lack_at = [&](std::size_t node) { return lack(mix(rows_[row][node], rows_[row + 1][node], r.share)); };
    const double wanted = double(number) * sum_below(kCosines - 1);
    std::size_t below = 0, above = kCosines - 1;
    while (above - below > 1) {
        const std::size_t middle = (below + above) / 2;
        (sum_below(middle) <= wanted ? below : above) = middle;
    }
    const double root = Lack(below, lack_at(below), lack_at(above)).place_of(wanted - sum_below(below)) / (kCosines - 1);
    return static_cast<float>(root * root);
}

}  // namespace occam::shade
