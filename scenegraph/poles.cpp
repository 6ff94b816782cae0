#include "scenegraph/poles.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/hash.h"
#include "scenegraph/cage_faces.h"

namespace occam {
namespace {

/// What is around a vertex.
struct Around {
    std::uint32_t faces = 0;
    std::uint32_t creases = 0, between_creases = 0;  ///< creases inside of the surface, and faces between two of them
    bool has_crease = false, may_smooth = false;     ///< has any crease, and one that is smooth after steps of subdivision
    bool is_corner = false;                          ///< the cage says so
    std::uint64_t border = 0;  ///< hashes of all edges of these faces, each as often as faces have it: 0 if none is a border
};

/// What is around the vertices of a cage.
class Surroundings {
public:
    explicit Surroundings(const Cage& cage) : all_(cage.positions.size())
    {
        add_faces(cage);
        for (const Corner& corner : cage.corners) all_[corner.vertex].is_corner |= corner.sharpness > 0;
        if (cage.creases.empty()) return;
        find_creases(cage);
        for_each_corner(cage, [&](std::uint32_t at, std::uint32_t last, std::uint32_t next) {
            if (all_[at].creases > 1 && is_crease(at, next) && is_crease(at, last)) ++all_[at].between_creases;
        });
    }

    /// Returns how many faces a smooth vertex has around which the surface shrinks as slowly as it may around this one.
    std::uint32_t faces_of_pole(std::uint32_t vertex) const noexcept
    {
        const Around& at = all_[vertex];
        const bool is_border = at.border != 0;
        const std::uint32_t smooth = is_border ? 2 * at.faces : at.faces;
        if (at.creases == 0 && !at.is_corner) return smooth;
        // A tip without sharp edges shrinks like a cone.
        if (at.creases == 0 && !is_border) return ~std::uint32_t(0);
        // A crease that ends inside of the surface leaves all faces on one side.
        const std::uint32_t parts = is_border ? at.creases + 1 : at.creases,
                            single = std::min(at.between_creases, parts - 1);
        // All parts but the widest have one face or, between two creases, two.
        const std::uint32_t others = is_border ? parts - 1 : single + 2 * (parts - 1 - single);
        const std::uint32_t widest = at.faces > others ? at.faces - others : 1;
        // In a corner the edge between two faces shrinks by half as its sharp neighbours do, which then add up.
        const bool is_corner = at.is_corner || at.creases + (is_border ? 2 : 0) > 2;
        return std::max({2 * widest, at.may_smooth ? smooth : 0, is_corner && widest == 2 ? 5u : 0u});
    }

private:
    /// Calls visit(vertex, the one before, the one behind) for each corner of a face.
    template <class Visit>
    static void for_each_corner(const Cage& cage, const Visit& visit)
    {
        for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t) {
            std::uint32_t last = face.back();
            for (std::size_t c = 0; c < face.size(); ++c) {
                visit(face[c], last, c + 1 < face.size() ? face[c + 1] : face.front());
                last = face[c];
            }
        });
    }
    void add_faces(const Cage& cage)
    {
        for_each_corner(cage, [&](std::uint32_t at, std::uint32_t, std::uint32_t next) {
            const std::uint64_t edge = mix_bits(edge_key(at, next));
            all_[at].border ^= edge;
            all_[next].border ^= edge;
            ++all_[at].faces;
        });
    }
    /// Finds the creases that divide what is around their ends: those at a border do not.
    void find_creases(const Cage& cage)
    {
        for (const Crease& crease : cage.creases) {
            if (!(crease.sharpness > 0)) continue;
            creases_.push_back(edge_key(crease.v0, crease.v1));
            for (const std::uint32_t v : {crease.v0, crease.v1}) {
                all_[v].has_crease = true;
                all_[v].may_smooth |= crease.sharpness < kInfiniteSharpness;
            }
        }
        std::ranges::sort(creases_);
        creases_.erase(std::unique(creases_.begin(), creases_.end()), creases_.end());
        std::vector<std::uint32_t> faces(creases_.size());
        for_each_corner(cage, [&](std::uint32_t at, std::uint32_t, std::uint32_t next) {
            if (!all_[at].has_crease || !all_[next].has_crease) return;
            const std::uint64_t key = edge_key(at, next);
            if (const auto found = std::ranges::lower_bound(creases_, key); found != creases_.end() && *found == key)
                ++faces[static_cast<std::size_t>(found - creases_.begin())];
        });
        std::size_t kept = 0;
        for (std::size_t i = 0; i < creases_.size(); ++i)
            if (faces[i] > 1) creases_[kept++] = creases_[i];
        creases_.resize(kept);
        for (const std::uint64_t key : creases_) {
            ++all_[key >> 32].creases;
            ++all_[key & 0xffffffff].creases;
        }
    }
    bool is_crease(std::uint32_t a, std::uint32_t b) const noexcept
    {
        return std::ranges::binary_search(creases_, edge_key(a, b));
    }

    std::vector<Around> all_;
    std::vector<std::uint64_t> creases_;
};

}  // namespace

void Poles::add(const Poles& other) noexcept
{
    for (std::size_t c = 0; c < longest.size(); ++c) longest[c] = std::max(longest[c], other.longest[c]);
}

void Poles::lengthen(const Poles& by) noexcept
{
    for (std::size_t c = 0; c < longest.size(); ++c) longest[c] += by.longest[c];
}

std::uint32_t Poles::class_of(std::uint32_t faces) noexcept
{
    if (faces < 5) return 0;
    std::size_t c = 0;
    while (faces > kMostFaces[c]) ++c;
    return 1u << c;
}

void Poles::add(std::uint32_t classes, double length) noexcept
{
    for (std::size_t c = 0; c < longest.size(); ++c)
        if (classes >> c & 1) longest[c] = std::max(longest[c], length);
}

Poles Poles::scaled(double factor) const noexcept
{
    Poles scaled = *this;
    for (double& length : scaled.longest) length *= factor;
    return scaled;
}

PoleFaces::PoleFaces(const Cage& cage)
{
    if (cage.scheme != Scheme::CatmullClark) return;
    const Surroundings surroundings(cage);
    for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t first) {
        const auto size = static_cast<std::uint32_t>(face.size());
        std::uint32_t corners = 0;
        for (const std::uint32_t v : face) corners |= Poles::class_of(surroundings.faces_of_pole(v));
        // The middle of a face becomes a vertex of as many faces as this has corners.
        const std::uint32_t middle = Poles::class_of(size);
        if ((corners | middle) != 0)
            faces_.push_back({static_cast<std::uint32_t>(first), size & 0xffff, corners & 0xff, middle & 0xff});
    });
    faces_.shrink_to_fit();
}

namespace {

/// Calls visit(edge) for each vector along a side of the face, and then, where a vertex is made in its middle, from there to
/// each of its corners.
template <class Visit>
void for_each_edge(std::span<const std::uint32_t> face, std::span<const Vec3f> positions, bool has_middle,
                   const Visit& visit)
{
    const auto corner = [&](std::size_t c) { return Vec3d(positions[face[c]]); };
    for (std::size_t c = 0; c < face.size(); ++c) visit(corner((c + 1) % face.size()) - corner(c), false);
    if (!has_middle) return;
    Vec3d middle(0);
    for (std::size_t c = 0; c < face.size(); ++c) middle += corner(c) / double(face.size());
    for (std::size_t c = 0; c < face.size(); ++c) visit(corner(c) - middle, true);
}

}  // namespace

Poles PoleFaces::lengths(const Face& face, const Cage& cage, std::span<const Vec3f> positions) const noexcept
{
    double sides = 0, all = 0;
    for_each_edge(std::span(cage.face_vertices).subspan(face.first, face.size), positions, face.middle != 0,
                  [&](const Vec3d& edge, bool is_to_middle) {
                      const double length = glm::length(edge);
                      all = std::max(all, length);
                      if (!is_to_middle) sides = std::max(sides, length);
                  });
    Poles poles;
    poles.add(face.corners, sides);
    poles.add(face.middle, all);
    return poles;
}

Poles PoleFaces::measure(const Cage& cage, std::span<const Vec3f> positions) const noexcept
{
    Poles poles;
    for (const Face& face : faces_) poles.add(lengths(face, cage, positions));
    return poles;
}

Vec3d PoleFaces::reach(const Cage& cage, std::span<const Vec3f> positions) const noexcept
{
    Vec3d reach(0);
    for (const Face& face : faces_)
        for_each_edge(std::span(cage.face_vertices).subspan(face.first, face.size), positions, face.middle != 0,
                      [&](const Vec3d& edge, bool) { reach = glm::max(reach, glm::abs(edge)); });
    return reach;
}

}  // namespace occam
