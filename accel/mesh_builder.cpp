#include "accel/mesh_builder.h"

namespace occam::accel {

MeshGrid* MeshBuilder::build(const GridSubject& of, std::span<const std::uint32_t> faces, const Material* material,
                             Arena& arena)
{
    micropolygons += faces.size();
    set_corners(of.cage, faces);
    return arena.make<MeshGrid>(of, trees_.build(faces, corners_, of.cage.segments + 1, arena), material);
}

void MeshBuilder::set_corners(const lod::PosedCage& cage, std::span<const std::uint32_t> faces)
{
    const Cage& source = cage.slot->cage;
    corners_.resize(3 * faces.size() * (static_cast<std::size_t>(cage.segments) + 1));
    std::size_t at = 0;
    for (int key = 0; key <= cage.segments; ++key)
        for (const std::uint32_t face : faces)
            for (std::size_t p = 0; p < 3; ++p)
                corners_[at++] = cage.at_key(key).vertex(source.face_vertices[std::size_t(face) * 3 + p]);
}

}  // namespace occam::accel
