#include "lod/patch_class.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "base/check.h"
#include "base/power_of_two.h"
#include "lod/patch_hull.h"

namespace occam::lod {
namespace {

// The parameters where a piece is sampled, well inside so that no neighbouring piece is touched.
constexpr std::array<double, 4> kSamples{0.125, 0.375, 0.625, 0.875};
// The parameters where the resulting piece is tested; they form no pattern with the samples.
constexpr std::array<std::array<double, 2>, 5> kTrials{{{0.5, 0.5}, {0.05, 0.07}, {0.96, 0.03}, {0.04, 0.94}, {0.93, 0.97}}};
// A piece is tested at these points, too, if there are creases: one of sharpness 6 or more touches none of the inner points.
constexpr std::array<std::array<double, 2>, 8> kBorderTrials{
    {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0.5, 0}, {0.5, 1}, {0, 0.5}, {1, 0.5}}};
// These are the lines on which a rectangle is tested for being cubic in one direction, and the places on each of them.
constexpr std::array<double, 4> kLines{0, 0.3, 0.5, 1};
constexpr std::array<double, 5> kTrialsOfLine{0, 0.05, 0.5, 0.93, 1};
// Stencils are accurate to 1e-14. Another piece differs by the jump of third derivatives, more than 1e-5 in all known cases.
constexpr double kAgree = 1e-9;
// Weights below this are rounding errors of the fit and become 0, so that a regular patch gets exact ones and zeros.
constexpr double kNoise = 1e-11;

// Writes the weights of n control points in a point and in both of its tangents, a row each.
void write_rows(const LimitStencil& stencil, std::size_t n, float* rows)
{
    for (std::size_t k = 0; k < n; ++k) {
        rows[k] = static_cast<float>(stencil.p[k]);
        rows[n + k] = static_cast<float>(stencil.du[k]);
        rows[2 * n + k] = static_cast<float>(stencil.dv[k]);
    }
}

std::array<double, 4> basis(double t)
{
    const double s = 1 - t;
    return {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6};
}

using Matrix4 = std::array<std::array<double, 4>, 4>;

// Returns the inverse of B with B[s][i] = basis_i(kSamples[s]), by Gauss-Jordan elimination with row exchange.
Matrix4 inverse_sampling()
{
    std::array<std::array<double, 8>, 4> a{};
    for (int s = 0; s < 4; ++s) {
        const auto b = basis(kSamples[s]);
        for (int i = 0; i < 4; ++i) a[s][i] = b[i];
        a[s][4 + s] = 1;
    }
    for (int c = 0; c < 4; ++c) {
        int pivot = c;
        for (int r = c + 1; r < 4; ++r)
            if (std::fabs(a[r][c]) > std::fabs(a[pivot][c])) pivot = r;
        std::swap(a[c], a[pivot]);
        const double d = a[c][c];
        for (double& x : a[c]) x /= d;
        for (int r = 0; r < 4; ++r) {
            if (r == c) continue;
            const double f = a[r][c];
            for (int k = 0; k < 8; ++k) a[r][k] -= f * a[c][k];
        }
    }
    Matrix4 inverse;
    for (int i = 0; i < 4; ++i)
        for (int s = 0; s < 4; ++s) inverse[i][s] = a[i][4 + s];
    return inverse;
}

}  // namespace

float PatchClass::Node::size_u() const noexcept { return power_of_two(-depth_u); }
float PatchClass::Node::size_v() const noexcept { return power_of_two(-depth_v); }

PatchClass::PatchClass(int control_count, std::unique_ptr<const LimitSource> source, int crease_depth, ClassAccount* account)
    : control_count_(control_count),
      crease_depth_(std::min(crease_depth, kDeepestOfCreases)),
      source_(std::move(source)),
      account_(account)
{
    count(sizeof(PatchClass));
    root_.may_halve_one_way = crease_depth_ > kDeepest;
}

PatchClass::~PatchClass()
{
    if (account_) account_->remove(counted_);
}

void PatchClass::count(std::size_t bytes) const noexcept
{
    if (!account_) return;
    counted_ += bytes;
    account_->add(bytes);
}

void PatchClass::discount(std::size_t bytes) const noexcept
{
    if (!account_) return;
    counted_ -= bytes;
    account_->remove(bytes);
}

const PatchClass::Node& PatchClass::look_into(const Node& node) const
{
    const std::lock_guard lock(mutex_);
    if (node.kind.load(std::memory_order_relaxed) != Node::Unknown) return node;
    classify(const_cast<Node&>(node));
    count(table_bytes(node));
    return node;
}

std::size_t PatchClass::table_bytes(const Node& node) const noexcept
{
    const std::size_t matrices = std::size_t(1) + is_deep(node.depth_u) + is_deep(node.depth_v);
    switch (node.kind.load(std::memory_order_relaxed)) {
        case Node::Split:
            return static_cast<std::size_t>(node.child_count()) * sizeof(Node);
        case Node::Bicubic:
            return (matrices * 16 + 1) * sizeof(float) * node.control_count;
        case Node::Direct:
            return 4 * 3 * static_cast<std::size_t>(control_count_) * sizeof(float);
        case Node::Unknown:
            break;
    }
    return 0;
}

std::size_t PatchClass::tree_bytes(const Node& node) const noexcept
{
    std::size_t bytes = table_bytes(node);
    for (int c = 0; node.children && c < node.child_count(); ++c) bytes += tree_bytes(node.children[c]);
    return bytes;
}

LimitStencil PatchClass::limit(double u, double v, LimitSource::Of of) const
{
    LimitStencil stencil;
    source_->evaluate(u, v, of, stencil);
    return stencil;
}

const PointStencil& PatchClass::corner(int corner) const
{
    return corners_[static_cast<std::size_t>(corner)].get_or_make([&] {
        const LimitStencil stencil = limit(corner & 1, corner >> 1);
        auto made = std::make_unique<PointStencil>();
        for (std::uint32_t k = 0; k < stencil.p.size(); ++k) {
            if (std::fabs(stencil.p[k]) < kNoise) continue;
            made->controls.push_back(k);
            made->weights.push_back(static_cast<float>(stencil.p[k]));
        }
        count(sizeof(PointStencil) + made->controls.size() * (sizeof(std::uint32_t) + sizeof(float)));
        return made;
    });
}

const PatchHull& PatchClass::make_hull() const
{
    return hull_.get_or_make([&] {
        // The hull uses the tree of the points. If there are creases, it uses a tree of strips of its own instead.
        Node strips;
        strips.may_halve_one_way = true;
        struct Discount {
            const PatchClass& kind;
            const Node& strips;
            ~Discount() { kind.discount(kind.tree_bytes(strips)); }
        };
        const Discount when_strips_end{*this, strips};  // also if there is no memory for the hull
        const bool takes_strips = crease_depth_ > 0 && !root_.may_halve_one_way;
        auto made = std::make_unique<const PatchHull>(*this, takes_strips ? strips : root_);
        count(made->bytes());
        return made;
    });
}

const PatchClass::Node& PatchClass::locate(float u, float v) const
{
    const Node* node = &root();
    while (node->kind.load(std::memory_order_relaxed) == Node::Split) {
        const int x = u >= node->u0 + node->size_u() * 0.5f, y = v >= node->v0 + node->size_v() * 0.5f;
        node = &resolve(node->child(x, y));
    }
    return *node;
}

void PatchClass::classify(Node& node) const
{
    if (fit_bicubic(node)) {
        node.kind.store(Node::Bicubic, std::memory_order_release);
        return;
    }
    // Strips cost little, so trees of strips go deeper: the squares at an extraordinary vertex, where the creases have
    // become smooth, are then as small as elsewhere.
    const int below = node.may_halve_one_way ? kBelowCreases : 0;
    const int deepest = std::max(kDeepest, crease_depth_ + below);
    const bool may_u = node.depth_u < deepest, may_v = node.depth_v < deepest;
    if (!may_u && !may_v) {
        fill_direct(node);
        node.kind.store(Node::Direct, std::memory_order_release);
        return;
    }
    bool halve_u = may_u, halve_v = may_v;
    if (may_u && may_v && node.may_halve_one_way) {
        halve_u = !is_cubic_along(node, false);
        halve_v = !is_cubic_along(node, true);
        if (!halve_u && !halve_v) halve_u = halve_v = true;
    }
    node.halves_u = halve_u;
    node.halves_v = halve_v;
    const int across = halve_u ? 2 : 1, children = node.child_count();
    node.children = std::make_unique<Node[]>(static_cast<std::size_t>(children));
    for (int c = 0; c < children; ++c) {
        Node& child = node.children[c];
        child.u0 = node.u0 + (c % across ? node.size_u() * 0.5f : 0);
        child.v0 = node.v0 + (c / across ? node.size_v() * 0.5f : 0);
        child.depth_u = node.depth_u + halve_u;
        child.depth_v = node.depth_v + halve_v;
        child.may_halve_one_way = node.may_halve_one_way;
    }
    node.kind.store(Node::Split, std::memory_order_release);
}

/// Returns whether the weights of all control points are cubic along lines of the rectangle in one direction.
bool PatchClass::is_cubic_along(const Node& node, bool along_v) const
{
    static const Matrix4 inverse = inverse_sampling();
    const std::size_t n = control_count_;
    const double size_u = power_of_two_double(-node.depth_u), size_v = power_of_two_double(-node.depth_v);
    std::array<LimitStencil, 4> samples;
    LimitStencil trial;
    for (const double line : kLines) {
        const auto evaluate = [&](double t, LimitStencil& out) {
            source_->evaluate(node.u0 + size_u * (along_v ? line : t), node.v0 + size_v * (along_v ? t : line),
                              LimitSource::Of::Point, out);
        };
        for (std::size_t s = 0; s < 4; ++s) evaluate(kSamples[s], samples[s]);
        for (const double t : kTrialsOfLine) {
            evaluate(t, trial);
            const auto b = basis(t);
            for (std::size_t k = 0; k < n; ++k) {
                double w = 0;
                for (std::size_t i = 0; i < 4; ++i)
                    for (std::size_t s = 0; s < 4; ++s) w += b[i] * inverse[i][s] * samples[s].p[k];
                if (std::fabs(w - trial.p[k]) > kAgree) return false;
            }
        }
    }
    return true;
}

bool PatchClass::fit_bicubic(Node& node) const
{
    static const Matrix4 inverse = inverse_sampling();
    const std::size_t n = control_count_;
    const double size_u = power_of_two_double(-node.depth_u), size_v = power_of_two_double(-node.depth_v);
    LimitStencil stencil;

    std::vector<double> samples(16 * n);
    for (int t = 0; t < 4; ++t)
        for (int s = 0; s < 4; ++s) {
            source_->evaluate(node.u0 + size_u * kSamples[s], node.v0 + size_v * kSamples[t], LimitSource::Of::Point,
                              stencil);
            std::copy(stencil.p.begin(), stencil.p.end(), samples.begin() + (t * 4 + s) * n);
        }
    // The control net is the tensor product of the inverse with itself, applied to the samples of each control point's
    // weights.
    std::vector<double> net(16 * n, 0.0);
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i)
            for (int t = 0; t < 4; ++t)
                for (int s = 0; s < 4; ++s) {
                    const double f = inverse[j][t] * inverse[i][s];
                    for (std::size_t k = 0; k < n; ++k) net[(j * 4 + i) * n + k] += f * samples[(t * 4 + s) * n + k];
                }
    const auto agrees = [&](const std::array<double, 2>& trial) {
        source_->evaluate(node.u0 + size_u * trial[0], node.v0 + size_v * trial[1], LimitSource::Of::Point, stencil);
        const auto bu = basis(trial[0]), bv = basis(trial[1]);
        for (std::size_t k = 0; k < n; ++k) {
            double w = 0;
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) w += bu[i] * bv[j] * net[(j * 4 + i) * n + k];
            if (std::fabs(w - stencil.p[k]) > kAgree) return false;
        }
        return true;
    };
    if (!std::all_of(kTrials.begin(), kTrials.end(), agrees)) return false;
    if (crease_depth_ > 0 && !std::all_of(kBorderTrials.begin(), kBorderTrials.end(), agrees)) return false;
    store_weights(node, net);
    return true;
}

/// Stores the weights of a bicubic piece.
/// net   of each of its 16 points, the weights of all control points
void PatchClass::store_weights(Node& node, const std::vector<double>& net) const
{
    const std::size_t n = control_count_;
    const auto rounded = [&](std::size_t i, std::size_t k) {
        const double w = net[i * n + k], exact = std::nearbyint(w);
        return static_cast<float>(std::fabs(w - exact) < kNoise ? exact : w);
    };
    std::vector<std::uint32_t> used;
    for (std::size_t k = 0; k < n; ++k) {
        bool is_used = false;
        for (std::size_t i = 0; i < 16; ++i) is_used |= rounded(i, k) != 0;
        if (is_used) used.push_back(static_cast<std::uint32_t>(k));
    }
    const std::size_t matrices = std::size_t(1) + is_deep(node.depth_u) + is_deep(node.depth_v);
    node.controls = std::make_unique<std::uint32_t[]>(used.size());
    node.weights = std::make_unique<float[]>(matrices * 16 * used.size());
    node.control_count = static_cast<std::uint32_t>(used.size());
    std::ranges::copy(used, node.controls.get());
    float* weights = node.weights.get();
    std::array<int, 16> ones{}, others{};
    for (const std::uint32_t k : used)
        for (std::size_t i = 0; i < 16; ++i) {
            const float w = *weights++ = rounded(i, k);
            ones[i] += w == 1.0f;
            others[i] += w != 1.0f && w != 0.0f;
            if (w == 1.0f) node.order[i] = static_cast<std::uint8_t>(k);
        }
    const auto add_differences = [&](auto&& first_of) {
        for (const std::uint32_t k : used)
            for (std::size_t i = 0; i < 16; ++i) *weights++ = static_cast<float>(net[i * n + k] - net[first_of(i) * n + k]);
    };
    if (is_deep(node.depth_u)) add_differences([](std::size_t i) { return i & ~std::size_t(3); });
    if (is_deep(node.depth_v)) add_differences([](std::size_t i) { return i & std::size_t(3); });
    node.is_plain = n < 256 && std::all_of(ones.begin(), ones.end(), [](int c) { return c == 1; }) &&
                    std::all_of(others.begin(), others.end(), [](int c) { return c == 0; });
}

void PatchClass::fill_direct(Node& node) const
{
    const std::size_t n = control_count_;
    node.weights = std::make_unique<float[]>(4 * 3 * n);
    for (int c = 0; c < 4; ++c) {
        const LimitStencil stencil = limit(node.u0 + (c & 1 ? node.size_u() : 0), node.v0 + (c & 2 ? node.size_v() : 0),
                                           LimitSource::Of::PointAndTangents);
        write_rows(stencil, n, &node.weights[c * 3 * n]);
    }
}

void PatchClass::direct_rows(const Node& leaf, float u, float v, float* rows) const
{
    const std::size_t n = control_count_;
    const bool right = u == leaf.u0 + leaf.size_u(), top = v == leaf.v0 + leaf.size_v();
    if ((right || u == leaf.u0) && (top || v == leaf.v0)) {
        const float* table = &leaf.weights[(int(right) + 2 * int(top)) * 3 * n];
        std::copy(table, table + 3 * n, rows);
        return;
    }
    write_rows(limit(u, v, LimitSource::Of::PointAndTangents), n, rows);
}

}  // namespace occam::lod
