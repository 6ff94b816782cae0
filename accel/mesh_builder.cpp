#include "accel/mesh_builder.h"

#include <algorithm>
#include <bit>

namespace occam::accel {
namespace {

constexpr std::size_t kFewTriangles = 4;  // so few triangles form one block

// Returns how many leaves the box tree has: twice as many as full blocks would take, and at least eight, which are tested at
// once. This leaves room to distribute triangles by the space that they take.
std::size_t leaves_for(std::size_t faces) noexcept
{
    const std::size_t full = (faces + IGrid::kBlock - 1) / IGrid::kBlock;
    return faces <= kFewTriangles ? 1 : std::max<std::size_t>(BoxTree::kGroup, 2 * std::bit_ceil(full));
}

}  // namespace

MeshGrid* MeshBuilder::build(const GridSubject& of, std::span<const std::uint32_t> faces, Arena& arena)
{
    micropolygons += faces.size();
    set_corners(of.cage, faces);
    leaves_.assign(leaves_for(faces.size()), {});
    cut(boxed_, 0, leaves_.size());
    const std::size_t keys = static_cast<std::size_t>(of.cage.segments) + 1,
                      blocks = leaves_.size() - static_cast<std::size_t>(std::count_if(leaves_.begin(), leaves_.end(),
                                                                                       [](auto&l) { return l.empty(); }));
    const std::size_t padded = blocks * IGrid::kBlock;
    const BoxTree boxes = make_box_tree(static_cast<int>(leaves_.size()), static_cast<int>(keys), arena,
                                        [&](int leaf, int key) {
                                            Box3f box;
                                            for (const lod::BoxedFace& face : leaves_[static_cast<std::size_t>(leaf)])
                                                for (std::size_t p = 0; p < 3; ++p)
                                                    box.add(corner(static_cast<std::size_t>(key), face.face, p));
                                            return box;
                                        });
    return arena.make<MeshGrid>(of, IGrid::Common{boxes, {}, static_cast<std::ptrdiff_t>(9 * padded)},
                                contents(faces, keys, padded, arena));
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

void MeshBuilder::cut(std::span<lod::BoxedFace> faces, std::size_t leaf, std::size_t leaves)
{
    const bool fits = faces.size() <= IGrid::kBlock;
    if (leaves > 1 && faces.size() > 1) {
        const lod::FaceSplit split = lod::split_faces(faces, leaves / 2 * IGrid::kBlock);
        if (split.pays || !fits) {
            cut(faces.first(split.count), leaf, leaves / 2);
            cut(faces.subspan(split.count), leaf + leaves / 2, leaves / 2);
            return;
        }
    }
    leaves_[leaf] = faces;
}

MeshContents MeshBuilder::contents(std::span<const std::uint32_t> faces, std::size_t keys, std::size_t padded, Arena& arena)
{
    const std::span<float> data = arena.make_array<float>(9 * padded * keys);
    const std::span<std::uint32_t> ids = arena.make_array<std::uint32_t>(padded);
    const std::span<std::uint16_t> block_at = arena.make_array<std::uint16_t>(leaves_.size());
    std::size_t block = 0;
    for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
        const std::span<const lod::BoxedFace> of = leaves_[leaf];
        block_at[leaf] = static_cast<std::uint16_t>(of.empty() ? 0 : block);
        if (of.empty()) continue;
        for (std::size_t i = 0; i < IGrid::kBlock; ++i) {
            // Copies of the last triangle fill its block: they are hit where it is hit, under the same number.
            const std::uint32_t face = of[std::min(i, of.size() - 1)].face;
            const std::size_t k = block * IGrid::kBlock + i;
            ids[k] = faces[face];
            for (std::size_t key = 0; key < keys; ++key)
                for (std::size_t p = 0; p < 3; ++p)
                    for (std::size_t a = 0; a < 3; ++a)
                        data[(key * 9 + p * 3 + a) * padded + k] = corner(key, face, p)[static_cast<int>(a)];
        }
        ++block;
    }
    MeshContents made;
    for (std::size_t c = 0; c < 9; ++c) made.corners[c] = &data[c * padded];
    made.ids = ids.data();
    made.block_at = block_at.data();
    return made;
}

}  // namespace occam::accel
