#include "lod/patch_hull.h"

namespace occam::lod {
namespace {

constexpr int kChordDepth =
    4;  // squares this small that are not bicubic are measured by their chords: rates up to 16 are exact

bool is_bicubic(const PatchClass::Node& node)
{
    return node.kind.load(std::memory_order_relaxed) == PatchClass::Node::Bicubic;
}

double sum(const CubicWeights& w, const float* q, int stride)
{
    double s = 0;
    for (int i = 0; i < 4; ++i) s += double(w.b[i]) * double(q[i * stride]);
    return s;
}

// (b - a) / size, of limit points.
void add_chord(WeightRows& rows, const LimitStencil& a, const LimitStencil& b, float size)
{
    rows.add([&](std::size_t k) { return (b.p[k] - a.p[k]) / double(size); });
}

}  // namespace

PatchHull::PatchHull(const PatchClass& kind)
    : points(kind.control_count()),
      corners(kind.control_count()),
      speed_u(kind.control_count()),
      speed_v(kind.control_count()),
      side_speed(4, WeightRows(kind.control_count()))
{
    add_points(kind, kind.root());
    add_speeds(kind, kind.root());
    for (int side = 0; side < 4; ++side) add_side_speeds(kind, kind.root(), side);
    for (WeightRows* rows : {&points, &corners, &speed_u, &speed_v}) rows->finish();
    for (WeightRows& rows : side_speed) rows.finish();
}

void PatchHull::add_points(const PatchClass& kind, const PatchClass::Node& node)
{
    const auto n = static_cast<std::size_t>(kind.control_count());
    switch (kind.resolve(node).kind.load(std::memory_order_relaxed)) {
        case PatchClass::Node::Split:
            for (int c = 0; c < 4; ++c) add_points(kind, node.children[c]);
            break;
        case PatchClass::Node::Direct:
            for (std::size_t c = 0; c < 4; ++c)
                corners.add([&](std::size_t k) { return double(node.weights[c * 3 * n + k]); });
            break;
        default: {
            const BezierWeights bezier = bezier_weights(0, 1);
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    points.add_new([&](std::size_t k) {
                        double s = 0;
                        for (int r = 0; r < 4; ++r)
                            s += double(bezier.row[j].b[r]) * sum(bezier.row[i], &node.weights[k * 16 + r * 4], 1);
                        return s;
                    });
        }
    }
}

void PatchHull::add_speeds(const PatchClass& kind, const PatchClass::Node& node)
{
    const float size = node.size();
    if (is_bicubic(kind.resolve(node))) {
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t i = 0; i < 3; ++i) {
                const auto difference = [&](std::size_t a, std::size_t b) {
                    return [&, a, b](std::size_t k) {
                        return (double(node.weights[k * 16 + b]) - double(node.weights[k * 16 + a])) / double(size);
                    };
                };
                speed_u.add_new(difference(j * 4 + i, j * 4 + i + 1));
                speed_v.add_new(difference(i * 4 + j, i * 4 + 4 + j));
            }
        return;
    }
    if (node.depth < kChordDepth) {
        for (int c = 0; c < 4; ++c) add_speeds(kind, node.children[c]);
        return;
    }
    LimitStencil p[4];
    for (int c = 0; c < 4; ++c) p[c] = kind.limit(node.u0 + (c & 1 ? size : 0), node.v0 + (c & 2 ? size : 0));
    add_chord(speed_u, p[0], p[1], size);
    add_chord(speed_u, p[2], p[3], size);
    add_chord(speed_v, p[0], p[2], size);
    add_chord(speed_v, p[1], p[3], size);
}

void PatchHull::add_side_speeds(const PatchClass& kind, const PatchClass::Node& node, int side)
{
    const bool along_v = side & 1, is_far = side == 1 || side == 2;
    const float size = node.size();
    if (is_bicubic(kind.resolve(node))) {
        const CubicWeights across = cubic_weights(is_far ? 1 : 0);
        for (int i = 0; i < 3; ++i)
            side_speed[std::size_t(side)].add_new([&](std::size_t k) {
                const float* w = &node.weights[k * 16];
                const auto control = [&](int c) { return along_v ? sum(across, w + c * 4, 1) : sum(across, w + c, 4); };
                return (control(i + 1) - control(i)) / double(size);
            });
        return;
    }
    if (node.depth < kChordDepth) {
        const int low = is_far ? (along_v ? 1 : 2) : 0, high = low + (along_v ? 2 : 1);
        add_side_speeds(kind, node.children[low], side);
        add_side_speeds(kind, node.children[high], side);
        return;
    }
    const float u = node.u0 + (along_v && is_far ? size : 0), v = node.v0 + (!along_v && is_far ? size : 0);
    add_chord(side_speed[std::size_t(side)], kind.limit(u, v), kind.limit(along_v ? u : u + size, along_v ? v + size : v),
              size);
}

}  // namespace occam::lod
