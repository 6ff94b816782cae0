#include "verify/ray_surface.h"

#include <algorithm>
#include <array>

#include "verify/closed.h"

namespace occam {
namespace {

struct DepthRange {
    double near, far;
};

/// Clips a triangle to a range across the ray: the result is a convex polygon of up to five corners, as triangles.
class DepthRangeClip {
public:
    DepthRangeClip(Vec3d from, Vec3d direction, DepthRange range, std::vector<Vec3d>& out)
        : from_(from), direction_(direction), range_(range), out_(out)
    {
    }

    void operator()(const Vec3d& a, const Vec3d& b, const Vec3d& c)
    {
        const auto [least, most] = std::minmax({depth(a), depth(b), depth(c)});
        if (most < range_.near || least > range_.far) return;
        if (least >= range_.near && most <= range_.far) {
            out_.insert(out_.end(), {a, b, c});
            return;
        }
        polygon_ = {a, b, c};
        cut(range_.near, 1);
        cut(range_.far, -1);
        for (std::size_t k = 2; k < polygon_.size(); ++k)
            out_.insert(out_.end(), {polygon_[0], polygon_[k - 1], polygon_[k]});
    }

private:
    double depth(const Vec3d& p) const { return glm::dot(p - from_, direction_); }

    void cut(double plane, double sign)
    {
        next_.clear();
        for (std::size_t k = 0; k < polygon_.size(); ++k) {
            const Vec3d p = polygon_[k], q = polygon_[(k + 1) % polygon_.size()];
            const double at_p = sign * (depth(p) - plane), at_q = sign * (depth(q) - plane);
            if (at_p >= 0) next_.push_back(p);
            if ((at_p >= 0) != (at_q >= 0)) next_.push_back(p + (q - p) * (at_p / (at_p - at_q)));
        }
        polygon_.swap(next_);
    }

    Vec3d from_, direction_;
    DepthRange range_;
    std::vector<Vec3d>& out_;
    std::vector<Vec3d> polygon_, next_;
};

std::vector<Vec3d> blended(const lod::LevelGrid& grid, Vec3d from, Vec3d direction, const lod::Blend<float>* blend)
{
    std::vector<Vec3d> vertices;
    for (int v = 0; v < grid.vertex_count; ++v) {
        const Vec3d fine = grid.at(v), coarse = grid.coarse_at(v);
        const float w = blend ? blend->weight(static_cast<float>(glm::dot(fine - from, direction))) : 0;
        vertices.push_back(glm::mix(fine, coarse, double(w)));
    }
    for (const lod::Hanging& h : grid.hanging)
        if (h.is_inside)
            vertices[std::size_t(grid.index(h.i, h.j))] = h.on(Vec3f(vertices[h.a]), Vec3f(vertices[h.c])).middle;
    return vertices;
}

}  // namespace

double winding_number_of_ray(Vec3d point, Vec3d from, Vec3d direction, const lod::RayLevels<float>& table, int finest,
                             const std::function<const std::vector<lod::LevelGrid>&(int level)>& dice)
{
    constexpr double kEverywhere = 1e30;
    double sum = 0;
    std::vector<Vec3d> corners;
    for (int pair = table.finest; pair <= table.coarsest; ++pair) {
        // Segments overlap by equal lengths on either side of their transitions.
        const auto transition = [&](int finer) {
            const double far = (double(table.end(finer)) + double(table.begin(finer + 1))) / 2;
            const double near = (double(table.begin(finer)) + double(table.end(finer + 1))) / 2;
            return table.begin(table.finest) <= table.begin(table.coarsest) ? far : near;
        };
        const bool grows = table.begin(table.finest) <= table.begin(table.coarsest);
        const double to_finer = pair == table.finest ? (grows ? -kEverywhere : kEverywhere) : transition(pair - 1);
        const double to_coarser = pair == table.coarsest ? (grows ? kEverywhere : -kEverywhere) : transition(pair);
        const DepthRange range = grows ? DepthRange{to_finer, to_coarser} : DepthRange{to_coarser, to_finer};
        if (!(range.near < range.far)) continue;

        const bool is_held = pair < finest;
        const lod::Blend<float> blend = table.blend(pair);
        corners.clear();
        DepthRangeClip clip(from, direction, range, corners);
        for (const lod::LevelGrid& grid : dice(std::max(pair, finest))) {
            const std::vector<Vec3d> v = blended(grid, from, direction, is_held ? nullptr : &blend);
            for (int y = 0; y < grid.tile.rows; ++y)
                for (int x = 0; x < grid.tile.columns; ++x) {
                    const auto at = [&](int dx, int dy) { return v[std::size_t(grid.index(x + dx, y + dy))]; };
                    clip(at(0, 0), at(1, 0), at(1, 1));
                    clip(at(0, 0), at(1, 1), at(0, 1));
                }
        }
        sum += winding_number(std::span<const Vec3d>(corners), point);
    }
    return sum;
}

}  // namespace occam
