#include "io/builtin/shapes.h"

#include <array>
#include <map>

#include "base/maths.h"

namespace occam::builtin {
namespace {

using maths::kPi;

// Adds faces to a cage, together with one UV value for each corner.
class Builder {
public:
    explicit Builder(std::string name)
    {
        cage_.name = std::move(name);
        cage_.uv_sets.emplace_back();
    }

    std::uint32_t vertex(Vec3f p)
    {
        cage_.positions.push_back(p);
        return static_cast<std::uint32_t>(cage_.positions.size() - 1);
    }
    std::uint32_t uv(Vec2f st)
    {
        cage_.uv_sets[0].values.push_back(st);
        return static_cast<std::uint32_t>(cage_.uv_sets[0].values.size() - 1);
    }
    struct Corner {
        std::uint32_t vertex, uv;
    };
    void face(const std::vector<Corner>& corners)
    {
        cage_.face_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
        for (const Corner& c : corners) {
            cage_.face_vertices.push_back(c.vertex);
            cage_.uv_sets[0].indices.push_back(c.uv);
        }
    }
    void crease(std::uint32_t v0, std::uint32_t v1, float sharpness)
    {
        if (sharpness > 0) cage_.creases.push_back({v0, v1, sharpness});
    }
    Cage take() { return std::move(cage_); }

private:
    Cage cage_;
};

Vec2f unit_circle(std::uint32_t j, std::uint32_t count)
{
    const float angle = 2 * kPi * float(j) / float(count);
    return {maths::cos(angle), maths::sin(angle)};
}

// Returns v for each ring: the length along the tube up to it, measured on the first column and scaled to [0, 1].
std::vector<float> lengths_along(const std::vector<Ring>& rings, bool is_closed)
{
    std::vector<float> v{0};
    const std::size_t pieces = is_closed ? rings.size() : rings.size() - 1;
    for (std::size_t i = 0; i < pieces; ++i) {
        const Ring &a = rings[i], &b = rings[(i + 1) % rings.size()];
        v.push_back(v.back() + glm::length(b.centre + b.x - a.centre - a.x));
    }
    for (float& x : v) x /= v.back();
    return v;
}

void add_rings(Builder& builder, const std::vector<Ring>& rings, std::uint32_t columns)
{
    for (const Ring& ring : rings)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const Vec2f c = unit_circle(j, columns);
            builder.vertex(ring.centre + ring.x * c.x + ring.y * c.y);
        }
    const auto count = static_cast<std::uint32_t>(rings.size());
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t j = 0; j < columns; ++j)
            builder.crease(i * columns + j, i * columns + (j + 1) % columns, rings[i].sharpness);
}

// Adds the quads between rings; v has one value for each row of UVs, which is one more than the rings if the tube is closed.
void add_walls(Builder& builder, std::uint32_t rings, std::uint32_t columns, const std::vector<float>& v)
{
    for (const float row : v)
        for (std::uint32_t j = 0; j <= columns; ++j) builder.uv({float(j) / float(columns), row});
    const auto corner = [&](std::uint32_t i, std::uint32_t j) {
        return Builder::Corner{i % rings * columns + j % columns, i * (columns + 1) + j};
    };
    for (std::uint32_t i = 0; i + 1 < v.size(); ++i)
        for (std::uint32_t j = 0; j < columns; ++j)
            builder.face({corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)});
}

// A ring whose x cross y points into the tube is closed clockwise.
void add_cap(Builder& builder, Cap cap, const Ring& ring, std::uint32_t first, std::uint32_t columns, bool is_start)
{
    std::vector<Builder::Corner> around;
    for (std::uint32_t k = 0; k < columns; ++k) {
        const std::uint32_t j = is_start ? columns - 1 - k : k;
        around.push_back({first + j, builder.uv(unit_circle(j, columns) * 0.5f + 0.5f)});
    }
    if (cap == Cap::Face) {
        builder.face(around);
        return;
    }
    const Builder::Corner middle{builder.vertex(ring.centre), builder.uv(Vec2f(0.5f))};
    for (std::uint32_t k = 0; k < columns; ++k) builder.face({around[k], around[(k + 1) % columns], middle});
}

// Sweeps a profile along x: profile(s) is (y, z) at a length s, which runs away from the eye or upwards.
template <class Profile>
Cage sheet(std::string name, float width, float length, std::uint32_t columns, std::uint32_t rows, Profile&& profile)
{
    Builder builder(std::move(name));
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j <= columns; ++j) {
            const float s = length * float(i) / float(rows), x = width * (float(j) / float(columns) - 0.5f);
            const Vec2f yz = profile(s);
            builder.vertex({x, yz.x, yz.y});
            builder.uv({x, s});
        }
    const auto corner = [&](std::uint32_t i, std::uint32_t j) {
        const std::uint32_t k = i * (columns + 1) + j;
        return Builder::Corner{k, k};
    };
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j)
            builder.face({corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)});
    return builder.take();
}

}  // namespace

Cage tube(std::string name, const std::vector<Ring>& rings, std::uint32_t columns, Cap first, Cap last)
{
    Builder builder(std::move(name));
    const auto count = static_cast<std::uint32_t>(rings.size());
    add_rings(builder, rings, columns);
    add_walls(builder, count, columns, lengths_along(rings, false));
    add_cap(builder, first, rings.front(), 0, columns, true);
    add_cap(builder, last, rings.back(), (count - 1) * columns, columns, false);
    return builder.take();
}

Cage closed_tube(std::string name, const std::vector<Ring>& rings, std::uint32_t columns)
{
    Builder builder(std::move(name));
    add_rings(builder, rings, columns);
    add_walls(builder, static_cast<std::uint32_t>(rings.size()), columns, lengths_along(rings, true));
    return builder.take();
}

Cage lathe(std::string name, const std::vector<Turn>& profile, std::uint32_t columns, Cap first, Cap last)
{
    std::vector<Ring> rings;
    for (const Turn& t : profile) rings.push_back({{0, t.y, 0}, {t.radius, 0, 0}, {0, 0, -t.radius}, t.sharpness});
    return tube(std::move(name), rings, columns, first, last);
}

Cage box(std::string name, Vec3f size, float margin, float sharpness)
{
    Builder builder(std::move(name));
    // The vertices lie on the surface of a 4 x 4 x 4 lattice.
    const auto coordinate = [&](int axis, int k) {
        const float half = size[axis] / 2;
        const std::array<float, 4> at{-half, margin - half, half - margin, half};
        return at[std::size_t(k)] + (axis == 1 ? half : 0);
    };
    std::map<std::array<int, 3>, std::uint32_t> known;
    const auto vertex = [&](std::array<int, 3> k) {
        const auto [it, is_new] = known.try_emplace(k, 0);
        if (is_new) it->second = builder.vertex({coordinate(0, k[0]), coordinate(1, k[1]), coordinate(2, k[2])});
        return it->second;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {0, 3}) {
            // The axes s and t are chosen so that s cross t points outwards.
            const int s = (axis + (side == 3 ? 1 : 2)) % 3, t = (axis + (side == 3 ? 2 : 1)) % 3;
            const auto corner = [&](int i, int j) {
                std::array<int, 3> k{};
                k[std::size_t(axis)] = side;
                k[std::size_t(s)] = i;
                k[std::size_t(t)] = j;
                const auto along = [&](int a, int at) { return (coordinate(a, at) - coordinate(a, 0)) / size[a]; };
                return Builder::Corner{vertex(k), builder.uv({along(s, i), 1 - along(t, j)})};
            };
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    builder.face({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
        }
    for (int axis = 0; axis < 3; ++axis)
        for (const int a : {0, 3})
            for (const int b : {0, 3}) {
                const int s = (axis + 1) % 3, t = (axis + 2) % 3;
                for (int k = 0; k < 3; ++k) {
                    std::array<int, 3> from{}, to{};
                    from[std::size_t(s)] = to[std::size_t(s)] = a;
                    from[std::size_t(t)] = to[std::size_t(t)] = b;
                    from[std::size_t(axis)] = k;
                    to[std::size_t(axis)] = k + 1;
                    builder.crease(vertex(from), vertex(to), sharpness);
                }
            }
    return builder.take();
}

Cage jack(std::string name, float length, float width)
{
    Builder builder(std::move(name));
    const std::uint32_t no_texture = builder.uv(Vec2f(0));
    const float half = width / 2;
    for (int k = 0; k < 8; ++k) builder.vertex(Vec3f(k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half));

    struct Step {
        float out, wide;
    };
    const std::array<Step, 4> steps{{{0.55f * length, 0.8f * half},
                                     {0.72f * length, 1.5f * half},
                                     {0.95f * length, 1.5f * half},
                                     {length, 0.8f * half}}};
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
            const int s = (axis + (side > 0 ? 1 : 2)) % 3, t = (axis + (side > 0 ? 2 : 1)) % 3;
            constexpr std::array<std::array<int, 2>, 4> kAround{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};  // seen from outside
            std::array<std::uint32_t, 4> ring{};
            for (std::size_t k = 0; k < 4; ++k) {
                unsigned bits = side > 0 ? 1u << axis : 0u;
                if (kAround[k][0] > 0) bits |= 1u << s;
                if (kAround[k][1] > 0) bits |= 1u << t;
                ring[k] = bits;
            }
            for (const Step& step : steps) {
                std::array<std::uint32_t, 4> next{};
                for (std::size_t k = 0; k < 4; ++k) {
                    Vec3f p;
                    p[axis] = float(side) * step.out;
                    p[s] = float(kAround[k][0]) * step.wide;
                    p[t] = float(kAround[k][1]) * step.wide;
                    next[k] = builder.vertex(p);
                }
                for (std::size_t k = 0; k < 4; ++k) {
                    const std::size_t l = (k + 1) % 4;
                    builder.face(
                        {{ring[k], no_texture}, {ring[l], no_texture}, {next[l], no_texture}, {next[k], no_texture}});
                }
                ring = next;
            }
            builder.face({{ring[0], no_texture}, {ring[1], no_texture}, {ring[2], no_texture}, {ring[3], no_texture}});
        }
    return builder.take();
}

Cage floor_sheet(std::string name, const FloorSize& size)
{
    return sheet(std::move(name), size.width, size.front - size.back, size.columns, size.rows,
                 [&](float s) { return Vec2f(0, size.front - s); });
}

Cage wall_sheet(std::string name, const WallSize& size)
{
    const float bend = size.radius * kPi / 2;
    return sheet(std::move(name), size.width, bend + size.height - size.radius, size.columns, size.rows, [&](float s) {
        if (s >= bend) return Vec2f(size.radius + s - bend, size.front - size.radius);
        const float angle = s / size.radius;
        return Vec2f(size.radius * (1 - maths::cos(angle)), size.front - size.radius * maths::sin(angle));
    });
}

}  // namespace occam::builtin
