// Poles: vertices around which the limit surface shrinks by less than half from one step of subdivision to the next, so that
// pieces of its curves become longer there than everywhere else. They are extraordinary vertices of five and more faces,
// vertices with three and more faces between two edges that a border or a crease keeps sharp, and sharp corners that are the
// tip of a cone or have two faces between such edges.
//
// Rings of faces around a vertex shrink by the subdominant eigenvalue of the subdivision matrix (Ball and Storry 1988).
// Between sharp edges it is that of a smooth vertex of twice as many faces, and at the tip of a cone that of infinitely
// many.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.h"
#include "scenegraph/cage.h"

namespace occam {

/// The longest edges of faces that meet at poles, by how many faces these have.
struct Poles {
    /// The most faces that the poles of a class have.
    static constexpr std::array<std::uint32_t, 4> kMostFaces{5, 6, 8, ~std::uint32_t(0)};
    std::array<double, 4> longest{};  ///< 0: there is no such pole

    double longest_of_all() const noexcept { return *std::max_element(longest.begin(), longest.end()); }
    void add(const Poles& other) noexcept;
    /// Adds lengths to lengths, class by class.
    void lengthen(const Poles& by) noexcept;
    /// Returns a mask of the class of a pole of so many faces; 0 for fewer than five, which make no pole.
    static std::uint32_t class_of(std::uint32_t faces) noexcept;
    /// Notes that edges of this length meet at poles of the classes in a mask.
    void add(std::uint32_t classes, double length) noexcept;
    Poles scaled(double factor) const noexcept;
    friend bool operator==(const Poles&, const Poles&) = default;
};

/// The faces of a sanitized cage that meet at poles. It needs no memory for a cage without poles; a mesh and a bilinear cage
/// have none.
class PoleFaces {
public:
    PoleFaces() = default;
    explicit PoleFaces(const Cage& cage);

    bool is_empty() const noexcept { return faces_.empty(); }
    /// Returns the longest edges with these positions, in their lengths. Displacement does not count.
    Poles measure(const Cage& cage, std::span<const Vec3f> positions) const noexcept;
    /// Returns how far these edges reach along each axis.
    Vec3d reach(const Cage& cage, std::span<const Vec3f> positions) const noexcept;
    /// Calls visit(vertices, lengths, all classes) for each face, where lengths are those of its edges with these positions.
    template <class Visit>
    void for_each(const Cage& cage, std::span<const Vec3f> positions, const Visit& visit) const
    {
        for (const Face& face : faces_)
            visit(std::span<const std::uint32_t>(cage.face_vertices).subspan(face.first, face.size),
                  lengths(face, cage, positions), std::uint32_t(face.corners | face.middle));
    }

private:
    struct Face {
        std::uint32_t first;        ///< number of its first corner
        std::uint32_t size : 16;    ///< corners
        std::uint32_t corners : 8;  ///< mask of the classes of poles among its corners
        std::uint32_t middle : 8;   ///< the same for the vertex that subdivision makes in its middle
    };
    Poles lengths(const Face& face, const Cage& cage, std::span<const Vec3f> positions) const noexcept;

    std::vector<Face> faces_;
};

}  // namespace occam
