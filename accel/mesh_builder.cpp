#include "accel/mesh_builder.h"

namespace occam::accel {

MeshGrid* MeshBuilder::build(const GridSubject& of, std::span<const std::uint32_t> faces, const Material* material,
                             Arena& arena)
{
    micropolygons += faces.size();
    set_corners(of.cage, faces);
    return arena.make<MeshGrid>(of, trees_.build(boxed_, faces, corners_, of.cage.segments + 1, arena), material);
}

void MeshBuilder::set_corners(const lod::PosedCage& cage, std::span<const std::uint32_t> faces)
{
    const Cage& source = cage.slot->cage;
    boxed_.resize(faces.size());
    corners_.resize(3 * faces.size() * (static_cast<std::size_t>(cage.segments) + 1));
    // Triangles that move are distributed by where they are at the middle of the shutter.
    const int middle = cage.segments / 2;
    for (int key = 0; key <= cage.segments; ++key)
        for (std::uint32_t f = 0; f < faces.size(); ++f) {
            if (key == 0) boxed_[f] = {{}, f};
            for (std::size_t p = 0; p < 3; ++p) {
                const Vec3f at = cage.at_key(key).vertex(source.face_vertices[std::size_t(faces[f]) * 3 + p]);
                corner(static_cast<std::size_t>(key), f, p) = at;
                if (key == middle) boxed_[f].box.add(at);
            }
        }
}

}  // namespace occam::accel
