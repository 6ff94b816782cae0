// Normals for polygons that come from a file without them.
#include <cmath>
#include <vector>

#include "base/maths.h"
#include "io/import/key_numbers.h"
#include "io/import/polygons.h"

namespace occam::import {

namespace {

// Returns the direction of `v`; if it has none, any unit vector will do, since what such a normal belongs to has no area.
Vec3d direction(Vec3d v)
{
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? v / length : Vec3d(0, 1, 0);
}

class Completion {
public:
    explicit Completion(Polygons& polygons) : polygons_(polygons), cage_(polygons.cage) {}

    void run()
    {
        polygons_.normal_indices.resize(cage_.face_vertices.size(), kNoIndex);
        for (std::uint32_t& index : polygons_.normal_indices)
            if (index >= polygons_.normals.size()) index = kNoIndex;  // before normals are added
        for_each_face([&](std::size_t f, std::size_t begin) { add_to_sums(f, begin); });
        for_each_face([&](std::size_t f, std::size_t begin) { complete(f, begin); });
    }

private:
    // Holds the normals around a vertex in one smoothing group, weighted with the faces' angles.
    struct Sum {
        Vec3d normals{0};
        double angles = 0;
        std::uint32_t index = kNoIndex;
    };

    template <class Visit>
    void for_each_face(Visit&& visit)
    {
        std::size_t begin = 0;
        for (std::size_t f = 0; f < cage_.face_sizes.size(); begin += cage_.face_sizes[f++]) visit(f, begin);
    }
    std::uint32_t group(std::size_t face) const { return polygons_.smoothing.empty() ? 0 : polygons_.smoothing[face]; }
    Vec3d place(std::size_t corner) const
    {
        const std::uint32_t v = cage_.face_vertices[corner];
        return v < cage_.positions.size() ? Vec3d(cage_.positions[v]) : Vec3d(0);
    }
    Vec3d face_normal(std::size_t f, std::size_t begin) const
    {
        Vec3d sum(0);
        const Vec3d first = place(begin);
        for (std::size_t c = 1; c + 1 < cage_.face_sizes[f]; ++c)
            sum += glm::cross(place(begin + c) - first, place(begin + c + 1) - first);
        return direction(sum);
    }
    Sum& sum(std::size_t f, std::size_t corner)
    {
        const std::uint32_t number = vertices_.number_of({group(f), cage_.face_vertices[corner]});
        if (number == sums_.size()) sums_.emplace_back();
        return sums_[number];
    }
    void add_to_sums(std::size_t f, std::size_t begin)
    {
        if (group(f) == 0) return;
        const Vec3d normal = face_normal(f, begin);
        const std::size_t size = cage_.face_sizes[f];
        for (std::size_t c = 0; c < size; ++c) {
            const Vec3d here = place(begin + c);
            const Vec3d next = direction(place(begin + (c + 1) % size) - here);
            const Vec3d last = direction(place(begin + (c + size - 1) % size) - here);
            const double angle = double(maths::acos(static_cast<float>(glm::dot(next, last))));
            Sum& of_vertex = sum(f, begin + c);
            of_vertex.normals += normal * angle;
            of_vertex.angles += angle;
        }
    }
    void complete(std::size_t f, std::size_t begin)
    {
        std::uint32_t of_face = kNoIndex;
        for (std::size_t corner = begin; corner < begin + cage_.face_sizes[f]; ++corner) {
            std::uint32_t& index = polygons_.normal_indices[corner];
            if (index != kNoIndex) continue;
            index = group(f) != 0 ? smooth(sum(f, corner)) : kNoIndex;
            if (index != kNoIndex) continue;
            if (of_face == kNoIndex) of_face = add(face_normal(f, begin));
            index = of_face;
        }
    }
    // Adds the mean normal and returns its index. There is none if the faces around the vertex cancel out, as the two sides
    // of a sheet do.
    std::uint32_t smooth(Sum& sum)
    {
        if (sum.index == kNoIndex && glm::length(sum.normals) > 1e-3 * sum.angles) sum.index = add(direction(sum.normals));
        return sum.index;
    }
    std::uint32_t add(Vec3d normal)
    {
        polygons_.normals.push_back(Vec3f(normal));
        return static_cast<std::uint32_t>(polygons_.normals.size() - 1);
    }

    Polygons& polygons_;
    const Cage& cage_;
    KeyNumbers<2> vertices_;  // of each smoothing group
    std::vector<Sum> sums_;   // by their numbers
};

}  // namespace

void complete_normals(Polygons& polygons)
{
    const auto is_smooth = [&] {
        for (const std::uint32_t group : polygons.smoothing)
            if (group != 0) return true;
        return false;
    };
    const auto lacks_one = [&] {
        for (const std::uint32_t index : polygons.normal_indices)
            if (index >= polygons.normals.size()) return true;
        return false;
    };
    if (polygons.normal_indices.empty() ? is_smooth() : lacks_one()) Completion(polygons).run();
}

}  // namespace occam::import
