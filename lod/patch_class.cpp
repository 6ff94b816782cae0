#include "lod/patch_class.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.h"
#include "base/power_of_two.h"
#include "lod/patch_hull.h"

namespace occam::lod {
namespace {

// Where a piece is sampled, well inside so that no neighbour's piece is met.
constexpr std::array<double, 4> kSamples{0.125, 0.375, 0.625, 0.875};
// Where the piece found is tried: no pattern with the samples.
constexpr std::array<std::array<double, 2>, 5> kTrials{{{0.5, 0.5}, {0.05, 0.07}, {0.96, 0.03}, {0.04, 0.94}, {0.93, 0.97}}};
// Stencils are accurate to 1e-14; another piece differs by its jump of third derivatives, above 1e-5 in all that were met.
constexpr double kAgree = 1e-9;
// Weights below this are rounding of the fit: a regular patch then gets exact ones and zeros.
constexpr double kNoise = 1e-11;

std::array<double, 4> basis(double t)
{
    const double s = 1 - t;
    return {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6};
}

using Matrix4 = std::array<std::array<double, 4>, 4>;

// Inverse of B with B[s][i] = basis_i(kSamples[s]), by Gauss and Jordan with row exchange.
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

float PatchClass::Node::size() const noexcept { return power_of_two(-depth); }

PatchClass::PatchClass(int control_count, std::unique_ptr<const LimitSource> source)
    : control_count_(control_count), source_(std::move(source))
{
}

PatchClass::~PatchClass() = default;

const PatchClass::Node& PatchClass::look_into(const Node& node) const
{
    const std::lock_guard lock(mutex_);
    if (node.kind.load(std::memory_order_relaxed) == Node::Unknown) classify(const_cast<Node&>(node));
    return node;
}

LimitStencil PatchClass::limit(double u, double v) const
{
    LimitStencil stencil;
    source_->evaluate(u, v, stencil);
    return stencil;
}

const PointStencil& PatchClass::corner(int corner) const
{
    const auto at = static_cast<std::size_t>(corner);
    std::call_once(corner_once_[at], [&] {
        const LimitStencil stencil = limit(corner & 1, corner >> 1);
        for (std::uint32_t k = 0; k < stencil.p.size(); ++k) {
            if (std::fabs(stencil.p[k]) < kNoise) continue;
            corners_[at].controls.push_back(k);
            corners_[at].weights.push_back(static_cast<float>(stencil.p[k]));
        }
    });
    return corners_[at];
}

const PatchHull& PatchClass::make_hull() const
{
    std::call_once(hull_once_, [&] {
        hull_ = std::make_unique<const PatchHull>(*this);
        hull_made_.store(hull_.get(), std::memory_order_release);
    });
    return *hull_;
}

const PatchClass::Node& PatchClass::locate(float u, float v) const
{
    const Node* node = &root();
    while (node->kind.load(std::memory_order_relaxed) == Node::Split) {
        const float half = node->size() * 0.5f;
        const int x = u >= node->u0 + half, y = v >= node->v0 + half;
        node = &resolve(node->children[y * 2 + x]);
    }
    return *node;
}

void PatchClass::classify(Node& node) const
{
    if (fit_bicubic(node)) {
        node.kind.store(Node::Bicubic, std::memory_order_release);
        return;
    }
    if (node.depth == kDeepest) {
        fill_direct(node);
        node.kind.store(Node::Direct, std::memory_order_release);
        return;
    }
    node.children = std::make_unique<Node[]>(4);
    const float half = node.size() * 0.5f;
    for (int c = 0; c < 4; ++c) {
        node.children[c].u0 = node.u0 + (c & 1 ? half : 0);
        node.children[c].v0 = node.v0 + (c & 2 ? half : 0);
        node.children[c].depth = node.depth + 1;
    }
    node.kind.store(Node::Split, std::memory_order_release);
}

bool PatchClass::fit_bicubic(Node& node) const
{
    static const Matrix4 inverse = inverse_sampling();
    const std::size_t n = control_count_;
    const double size = power_of_two_double(-node.depth);
    LimitStencil stencil;

    std::vector<double> samples(16 * n);
    for (int t = 0; t < 4; ++t)
        for (int s = 0; s < 4; ++s) {
            source_->evaluate(node.u0 + size * kSamples[s], node.v0 + size * kSamples[t], stencil);
            std::copy(stencil.p.begin(), stencil.p.end(), samples.begin() + (t * 4 + s) * n);
        }
    // Control net = inverse (x) inverse applied to the samples, for each control point's weights.
    std::vector<double> net(16 * n, 0.0);
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i)
            for (int t = 0; t < 4; ++t)
                for (int s = 0; s < 4; ++s) {
                    const double f = inverse[j][t] * inverse[i][s];
                    for (std::size_t k = 0; k < n; ++k) net[(j * 4 + i) * n + k] += f * samples[(t * 4 + s) * n + k];
                }
    for (const auto& trial : kTrials) {
        source_->evaluate(node.u0 + size * trial[0], node.v0 + size * trial[1], stencil);
        const auto bu = basis(trial[0]), bv = basis(trial[1]);
        for (std::size_t k = 0; k < n; ++k) {
            double w = 0;
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) w += bu[i] * bv[j] * net[(j * 4 + i) * n + k];
            if (std::fabs(w - stencil.p[k]) > kAgree) return false;
        }
    }
    node.weights = std::make_unique<float[]>(16 * n);
    std::array<int, 16> ones{}, others{};
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t i = 0; i < 16; ++i) {
            const double w = net[i * n + k];
            const double exact = std::nearbyint(w);
            const float rounded = static_cast<float>(std::fabs(w - exact) < kNoise ? exact : w);
            node.weights[k * 16 + i] = rounded;
            ones[i] += rounded == 1.0f;
            others[i] += rounded != 1.0f && rounded != 0.0f;
            if (rounded == 1.0f) node.order[i] = static_cast<std::uint8_t>(k);
        }
    node.is_plain = n < 256 && std::all_of(ones.begin(), ones.end(), [](int c) { return c == 1; }) &&
                    std::all_of(others.begin(), others.end(), [](int c) { return c == 0; });
    return true;
}

void PatchClass::fill_direct(Node& node) const
{
    const std::size_t n = control_count_;
    node.weights = std::make_unique<float[]>(4 * 3 * n);
    LimitStencil stencil;
    for (int c = 0; c < 4; ++c) {
        source_->evaluate(node.u0 + (c & 1 ? node.size() : 0), node.v0 + (c & 2 ? node.size() : 0), stencil);
        float* rows = &node.weights[c * 3 * n];
        for (std::size_t k = 0; k < n; ++k) {
            rows[k] = static_cast<float>(stencil.p[k]);
            rows[n + k] = static_cast<float>(stencil.du[k]);
            rows[2 * n + k] = static_cast<float>(stencil.dv[k]);
        }
    }
}

void PatchClass::direct_rows(const Node& leaf, float u, float v, float* rows) const
{
    const std::size_t n = control_count_;
    const float size = leaf.size();
    const bool right = u == leaf.u0 + size, top = v == leaf.v0 + size;
    if ((right || u == leaf.u0) && (top || v == leaf.v0)) {
        const float* table = &leaf.weights[(int(right) + 2 * int(top)) * 3 * n];
        std::copy(table, table + 3 * n, rows);
        return;
    }
    LimitStencil stencil;
    source_->evaluate(u, v, stencil);
    for (std::size_t k = 0; k < n; ++k) {
        rows[k] = static_cast<float>(stencil.p[k]);
        rows[n + k] = static_cast<float>(stencil.du[k]);
        rows[2 * n + k] = static_cast<float>(stencil.dv[k]);
    }
}

}  // namespace occam::lod
