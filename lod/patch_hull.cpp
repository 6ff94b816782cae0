#include "lod/patch_hull.h"

#include <algorithm>

namespace occam::lod {

/// The weights of four points: those of control point k start at k * 4.
struct PatchHull::Row {
    std::vector<float> weights;
    float speed;
};

namespace {

bool is_bicubic(const PatchClass::Node& node)
{
    return node.kind.load(std::memory_order_relaxed) == PatchClass::Node::Bicubic;
}

double sum(const CubicWeights& w, const double* q)
{
    return double(w.b[0]) * q[0] + double(w.b[1]) * q[1] + double(w.b[2]) * q[2] + double(w.b[3]) * q[3];
}

// Returns the weight of one of its control points for Bezier point (i, j) of a bicubic square.
float bezier_weight(const PatchClass::Node& node, std::size_t control, std::size_t i, std::size_t j)
{
    static const BezierWeights bezier = bezier_weights(0, 1);
    double along[4];
    for (std::size_t r = 0; r < 4; ++r) {
        double row[4];
        for (std::size_t c = 0; c < 4; ++c) row[c] = double(node.weights[control * 16 + r * 4 + c]);
        along[r] = sum(bezier.row[i], row);
    }
    return static_cast<float>(sum(bezier.row[j], along));
}

// Returns the offset of row or column i of a lattice over a square whose side along that axis is `size`.
float lattice_step(float size, std::size_t i) { return float(std::min<std::size_t>(i, 2)) * 0.5f * size; }

// Returns whether a rectangle that is not bicubic must be split.
bool is_opened(const PatchClass& kind, const PatchClass::Node& node)
{
    const int residual = kind.crease_depth() + PatchHull::kResidualDepth;
    return node.kind.load(std::memory_order_relaxed) == PatchClass::Node::Split &&
           std::min(node.depth_u, node.depth_v) < residual;
}

template <class Row>
void add_rows(const PatchClass& kind, const PatchClass::Node& node, int side, std::vector<Row>& rows)
{
    const bool along_v = side & 1, is_far = side == 1 || side == 2;
    const bool is_net = is_bicubic(kind.resolve(node));
    if (!is_net && is_opened(kind, node)) {
        const PatchClass::Node& low = along_v ? node.child(is_far, 0) : node.child(0, is_far);
        const PatchClass::Node& high = along_v ? node.child(is_far, 1) : node.child(1, is_far);
        add_rows(kind, low, side, rows);
        if (&low != &high) add_rows(kind, high, side, rows);
        return;
    }
    const auto n = static_cast<std::size_t>(kind.control_count());
    Row& row = rows.emplace_back();
    row.weights.resize(n * 4);
    row.speed = (is_net ? 3 : 2) / (along_v ? node.size_v() : node.size_u());
    for (std::size_t i = 0; i < 4; ++i) {
        if (is_net) {
            const std::size_t across = is_far ? 3 : 0;
            for (std::size_t k = 0; k < node.control_count; ++k)
                row.weights[node.controls[k] * 4 + i] = along_v ? bezier_weight(node, k, across, i)
                                                                : bezier_weight(node, k, i, across);
            continue;
        }
        const float t = lattice_step(along_v ? node.size_v() : node.size_u(), i);
        const float across = is_far ? (along_v ? node.size_u() : node.size_v()) : 0;
        const LimitStencil point = along_v ? kind.limit(node.u0 + across, node.v0 + t)
                                           : kind.limit(node.u0 + t, node.v0 + across);
        for (std::size_t k = 0; k < n; ++k) row.weights[k * 4 + i] = static_cast<float>(point.p[k]);
    }
}

}  // namespace

std::size_t PatchHull::bytes() const noexcept
{
    return sizeof *this + weights.capacity() * sizeof(float) + speeds.capacity() * sizeof(speeds[0]) +
           (controls.capacity() + first_rows.capacity()) * sizeof(std::uint32_t);
}

void PatchHull::add_lattice(const PatchClass& kind, const PatchClass::Node& square)
{
    const auto n = static_cast<std::size_t>(kind.control_count());
    std::vector<float> group(n * 16);
    for (std::size_t r = 0; r < 16; ++r) {
        const LimitStencil point = kind.limit(square.u0 + lattice_step(square.size_u(), r % 4),
                                              square.v0 + lattice_step(square.size_v(), r / 4));
        for (std::size_t k = 0; k < n; ++k) group[k * 16 + r] = static_cast<float>(point.p[k]);
    }
    add_group(group);
    speeds.push_back({2 / square.size_u(), 2 / square.size_v()});
}

PatchHull::PatchHull(const PatchClass& kind, const PatchClass::Node& root)
{
    std::vector<const PatchClass::Node*> residual;
    add_nets(kind, root, residual);
    nets = speeds.size();
    for (const PatchClass::Node* square : residual) add_lattice(kind, *square);
    squares = speeds.size();
    if (!is_bicubic(root)) add_sides(kind, root);
    weights.shrink_to_fit();
    controls.shrink_to_fit();
}

void PatchHull::add_sides(const PatchClass& kind, const PatchClass::Node& root)
{
    std::vector<Row> together;
    for (std::size_t side = 0; side < 4; ++side) {
        std::vector<Row> rows;
        add_rows(kind, root, static_cast<int>(side), rows);
        if (rows.size() == 1) {
            sides[side].first_row = static_cast<std::uint8_t>(together.size());
            sides[side].row_end = static_cast<std::uint8_t>(together.size() + 1);
            together.push_back(std::move(rows.front()));
            continue;
        }
        sides[side].first = static_cast<std::uint16_t>(speeds.size());
        for (std::size_t row = 0; row < rows.size(); row += 4) add_borders(rows, row);
        sides[side].count = static_cast<std::uint16_t>(speeds.size() - sides[side].first);
    }
    if (together.empty()) return;
    for (Side& side : sides)
        if (side.count == 0) {
            side.first = static_cast<std::uint16_t>(speeds.size());
            side.count = 1;
        }
    add_borders(together, 0);
}

void PatchHull::add_group(const std::vector<float>& all)
{
    for (std::size_t k = 0; k < all.size() / 16; ++k) {
        const auto row = all.begin() + static_cast<std::ptrdiff_t>(k * 16);
        if (std::all_of(row, row + 16, [](float w) { return w == 0; })) continue;
        weights.insert(weights.end(), row, row + 16);
        controls.push_back(static_cast<std::uint32_t>(k));
    }
    first_rows.push_back(static_cast<std::uint32_t>(controls.size()));
}

// Adds the group of rows [first, first + 4); rows that do not exist get weights of 0.
void PatchHull::add_borders(const std::vector<Row>& rows, std::size_t first)
{
    const std::size_t n = rows[first].weights.size() / 4;
    std::vector<float> group(n * 16);
    std::array<float, 4>& speed = speeds.emplace_back();
    speed = {};
    for (std::size_t row = 0; row < std::min<std::size_t>(4, rows.size() - first); ++row) {
        speed[row] = rows[first + row].speed;
        for (std::size_t k = 0; k < n; ++k) std::copy_n(&rows[first + row].weights[k * 4], 4, &group[k * 16 + row * 4]);
    }
    add_group(group);
}

void PatchHull::add_nets(const PatchClass& kind, const PatchClass::Node& node,
                         std::vector<const PatchClass::Node*>& residual)
{
    if (is_bicubic(kind.resolve(node))) {
        std::vector<float> group(static_cast<std::size_t>(kind.control_count()) * 16);
        for (std::size_t k = 0; k < node.control_count; ++k)
            for (std::size_t r = 0; r < 16; ++r) group[node.controls[k] * 16 + r] = bezier_weight(node, k, r % 4, r / 4);
        add_group(group);
        speeds.push_back({3 / node.size_u(), 3 / node.size_v()});
    } else if (is_opened(kind, node)) {
        for (int c = 0; c < node.child_count(); ++c) add_nets(kind, node.children[c], residual);
    } else {
        residual.push_back(&node);
    }
}

}  // namespace occam::lod
