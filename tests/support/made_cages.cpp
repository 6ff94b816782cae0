#include "tests/support/made_cages.h"

#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <stdexcept>

#include "base/hash.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

using Face = std::vector<std::uint32_t>;

Cage cage_of(std::vector<Vec3f> positions, const std::vector<Face>& faces)
{
    Cage cage;
    cage.positions = std::move(positions);
    for (const Face& face : faces) {
        cage.face_sizes.push_back(static_cast<std::uint32_t>(face.size()));
        cage.face_vertices.insert(cage.face_vertices.end(), face.begin(), face.end());
    }
    return cage;
}

/// Gives every edge of a cage the same sharpness.
Cage creased(Cage cage, float sharpness)
{
    std::size_t first = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t i = 0; i < size; ++i) {
            const std::uint32_t a = cage.face_vertices[first + i], b = cage.face_vertices[first + (i + 1) % size];
            if (a < b) cage.creases.push_back({a, b, sharpness});
        }
        first += size;
    }
    return cage;
}

Cage with_creases(Cage cage, std::vector<Crease> creases)
{
    cage.creases = std::move(creases);
    return cage;
}

Cage with_corners(Cage cage, std::vector<Corner> corners)
{
    cage.corners = std::move(corners);
    return cage;
}

Cage bilinear(Cage cage)
{
    cage.scheme = Scheme::Bilinear;
    return cage;
}

Cage cube()
{
    return cage_of({{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}},
                   {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

Cage tetrahedron()
{
    return cage_of({{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

Cage octahedron()
{
    return cage_of({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                   {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
}

/// Returns a pyramid of a square and four triangles, so that triangles lie beside a quad.
Cage pyramid()
{
    return cage_of({{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, 1.6f, 0}},
                   {{0, 1, 2, 3}, {1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}});
}

/// Returns a house: two pentagons, four walls and roofs, and a floor.
Cage house()
{
    std::vector<Vec3f> p;
    for (const float z : {-1.2f, 1.2f})
        for (const Vec2f xy : {Vec2f(-1, -1), Vec2f(1, -1), Vec2f(1, 0.6f), Vec2f(0, 1.5f), Vec2f(-1, 0.6f)})
            p.push_back({xy.x, xy.y, z});
    std::vector<Face> faces = {{4, 3, 2, 1, 0}, {5, 6, 7, 8, 9}};
    for (std::uint32_t i = 0; i < 5; ++i) faces.push_back({i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i});
    return cage_of(p, faces);
}

/// Returns the surface of those of three by three by three cells for which `is_filled` is true. It has concave corners of
/// valence 5 and 6.
template <class Filled>
Cage cells(Filled&& is_filled)
{
    std::map<std::array<int, 3>, std::uint32_t> numbers;
    std::vector<Vec3f> positions;
    std::vector<Face> faces;
    const auto vertex = [&](std::array<int, 3> at) {
        const auto [found, is_new] = numbers.try_emplace(at, static_cast<std::uint32_t>(positions.size()));
        if (is_new) positions.push_back({float(at[0]) - 1.5f, float(at[1]) - 1.5f, float(at[2]) - 1.5f});
        return found->second;
    };
    const auto stands = [&](std::array<int, 3> c) {
        for (const int x : c)
            if (x < 0 || x > 2) return false;
        return is_filled(c[0], c[1], c[2]);
    };
    for (int z = 0; z < 3; ++z)
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 3; ++x)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (const int side : {0, 1}) {
                        std::array<int, 3> cell = {x, y, z}, beside = cell;
                        beside[axis] += side ? 1 : -1;
                        if (!stands(cell) || stands(beside)) continue;
                        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
                        std::array<int, 3> corner = cell;
                        corner[axis] += side;
                        Face face;
                        for (const auto& [du, dv] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
                            std::array<int, 3> at = corner;
                            at[u] += du;
                            at[v] += dv;
                            face.push_back(vertex(at));
                        }
                        if (!side) std::swap(face[1], face[3]);
                        faces.push_back(face);
                    }
    return cage_of(positions, faces);
}

/// Returns a closed box of n x n quads on each side, whose vertices lie on a ball and are moved a little at random.
Cage rough_ball(int n, float noise, std::uint64_t seed)
{
    std::map<std::array<int, 3>, std::uint32_t> numbers;
    std::vector<Vec3f> positions;
    std::vector<Face> faces;
    std::uint64_t state = seed;
    const auto random = [&] { return float(mix_bits(++state) >> 40) * 0x1p-23f - 1; };
    const auto vertex = [&](std::array<int, 3> at) {
        const auto [found, is_new] = numbers.try_emplace(at, static_cast<std::uint32_t>(positions.size()));
        if (is_new) {
            const Vec3f p(float(2 * at[0] - n), float(2 * at[1] - n), float(2 * at[2] - n));
            positions.push_back(glm::normalize(p) * (1 + noise * random()));
        }
        return found->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const int side : {0, n})
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    Face face;
                    for (const auto& [du, dv] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
                        std::array<int, 3> at{};
                        at[axis] = side;
                        at[(axis + 1) % 3] = i + du;
                        at[(axis + 2) % 3] = j + dv;
                        face.push_back(vertex(at));
                    }
                    if (side == 0) std::swap(face[1], face[3]);
                    faces.push_back(face);
                }
    return cage_of(positions, faces);
}

/// Splits every second quad of a cage into two triangles.
Cage half_split(const Cage& quads)
{
    std::vector<Face> faces;
    for (std::size_t f = 0; f < quads.face_sizes.size(); ++f) {
        const auto corner = [&](std::size_t i) { return quads.face_vertices[4 * f + i]; };
        if (f % 2) faces.push_back({corner(0), corner(1), corner(2), corner(3)});
        else {
            faces.push_back({corner(0), corner(1), corner(2)});
            faces.push_back({corner(0), corner(2), corner(3)});
        }
    }
    return cage_of(quads.positions, faces);
}

/// Returns an open, wavy sheet of n x m quads.
Cage sheet(std::uint32_t n, std::uint32_t m)
{
    std::vector<Vec3f> p;
    std::vector<Face> faces;
    for (std::uint32_t j = 0; j <= m; ++j)
        for (std::uint32_t i = 0; i <= n; ++i)
            p.push_back({float(i), float(j), 0.4f * std::sin(1.7f * float(i)) * std::cos(1.1f * float(j))});
    for (std::uint32_t j = 0; j < m; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t at = j * (n + 1) + i;
            faces.push_back({at, at + 1, at + n + 2, at + n + 1});
        }
    return cage_of(p, faces);
}

Cage with_boundary(Cage cage, BoundaryRule rule)
{
    cage.boundary = rule;
    return cage;
}

Cage with_holes(Cage cage, std::vector<std::uint32_t> holes)
{
    cage.holes = std::move(holes);
    return cage;
}

/// Returns an open fan of n triangles about one vertex.
Cage fan(std::uint32_t n)
{
    std::vector<Vec3f> p = {{0, 0, 0.5f}};
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i <= n; ++i) {
        const float a = 4.5f * float(i) / float(n);
        p.push_back({std::cos(a), std::sin(a), 0});
        if (i > 0) faces.push_back({0, i, i + 1});
    }
    return cage_of(p, faces);
}

/// Returns quads about a pole: the faces of a spindle, joined in pairs.
Cage quad_pole(std::uint32_t valence)
{
    const Cage triangles = spindle(2 * valence);
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < valence; ++i) {
        const std::uint32_t a = 2 + 2 * i, b = a + 1, c = 2 + (2 * i + 2) % (2 * valence);
        faces.push_back({0, c, b, a});
        faces.push_back({1, a, b, c});
    }
    return cage_of(triangles.positions, faces);
}

void add_creased(std::vector<MadeCage>& all)
{
    for (const auto& [name, sharpness] :
         {std::pair("0_5", 0.5f), std::pair("2", 2.0f), std::pair("2_75", 2.75f), std::pair("infinite", 10.0f)})
        all.push_back({std::string("cube_creases_") + name, creased(cube(), sharpness)});
    all.push_back(
        {"cube_crease_loops", with_creases(cube(), {{4, 5, 10}, {5, 6, 10}, {6, 7, 10}, {7, 4, 10}, {0, 1, 3.25f}})});
    all.push_back({"cube_dart", with_creases(cube(), {{0, 1, 10}, {1, 2, 10}})});
    all.push_back({"cube_corners", with_corners(cube(), {{0, 10}, {6, 2.5f}, {3, 1}})});
    all.push_back({"pyramid_creases", with_creases(pyramid(), {{0, 1, 10}, {1, 2, 1.5f}, {0, 4, 2}, {2, 4, 10}})});
    all.push_back({"tetrahedron_creases", creased(tetrahedron(), 1.25f)});
    all.push_back({"torus_creases", with_creases(torus(), {{0, 1, 10}, {1, 2, 10}, {2, 3, 2}, {3, 4, 0.75f}, {5, 10, 10}})});
    Cage pole = spindle(9);
    pole.creases = {{0, 2, 10}, {2, 3, 2.5f}, {4, 1, 0.7f}, {3, 4, 10}};
    all.push_back({"pole_9_creases", std::move(pole)});
}

void add_open(std::vector<MadeCage>& all)
{
    const auto add = [&](const char* name, Cage cage) { all.push_back({name, std::move(cage), false}); };
    add("sheet_edge_corner", sheet(3, 4));
    add("sheet_edge_only", with_boundary(sheet(3, 4), BoundaryRule::EdgeOnly));
    add("sheet_none", with_boundary(sheet(4, 5), BoundaryRule::None));
    add("sheet_creases", with_creases(sheet(4, 4), {{6, 7, 10}, {7, 8, 10}, {7, 12, 2.5f}, {12, 17, 2.5f}}));
    add("sheet_hole", with_holes(sheet(4, 4), {5, 10}));
    add("sheet_triangles", half_split(sheet(4, 3)));
    add("sheet_bilinear", bilinear(sheet(3, 3)));
    add("fan_7", fan(7));
    add("one_quad", sheet(1, 1));
    add("cube_hole", with_holes(cube(), {1}));
}

}  // namespace

std::vector<MadeCage> made_cages()
{
    std::vector<MadeCage> all;
    const auto add = [&](const char* name, Cage cage) { all.push_back({name, std::move(cage)}); };
    add("cube", cube());
    add("tetrahedron", tetrahedron());
    add("octahedron", octahedron());
    add("pyramid", pyramid());
    add("house", house());
    add("torus", torus());
    add("torus_even", torus(8, 6, false));
    add("prism_3", prism(3));
    add("prism_7", prism(7));
    add("prism_40", prism(40));
    add("pole_3", spindle(3));
    add("pole_9", spindle(9));
    add("pole_64", spindle(64));
    add("pole_360", spindle(360));
    add("quad_pole_8", quad_pole(8));
    add("cells_corner", cells([](int x, int y, int z) { return x + y + z < 3; }));
    add("cells_ring", cells([](int x, int y, int z) { return z == 1 && !(x == 1 && y == 1); }));
    add("cells_frame", cells([](int x, int y, int z) { return (x == 1) + (y == 1) + (z == 1) < 2; }));
    add("ball_dense", rough_ball(8, 0, 1));
    add("ball_rough", rough_ball(4, 0.15f, 2));
    add("ball_quads_and_triangles", half_split(rough_ball(6, 0.04f, 3)));
    add("cube_bilinear", bilinear(cube()));
    add("house_bilinear", bilinear(house()));
    add("ball_bilinear", bilinear(rough_ball(2, 0.2f, 4)));
    add_creased(all);
    add_open(all);
    return all;
}

Cage made_cage(const std::string& name)
{
    for (MadeCage& made : made_cages())
        if (made.name == name) return std::move(made.cage);
    throw std::out_of_range("no made cage is called " + name);
}

}  // namespace occam::test
