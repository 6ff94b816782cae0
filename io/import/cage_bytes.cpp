#include "io/import/cage_bytes.h"

#include <vector>

namespace occam::import {

namespace {

template <class T>
std::size_t bytes_of_list(const std::vector<T>& list)
{
    return list.size() * sizeof(T);
}

}  // namespace

std::size_t bytes_of(const Cage& cage)
{
    const auto all = [](const auto&... lists) { return (bytes_of_list(lists) + ...); };
    std::size_t bytes = sizeof(Cage) + cage.name.size() +
                        all(cage.positions, cage.face_sizes, cage.face_vertices, cage.creases, cage.corners, cage.holes,
                            cage.normals, cage.uv_sets, cage.colors, cage.color_indices, cage.materials, cage.face_slots,
                            cage.morph_targets, cage.morph_weights, cage.skin.joints, cage.skin.weights);
    for (const UvSet& set : cage.uv_sets) bytes += all(set.values, set.indices);
    for (const MorphTarget& target : cage.morph_targets) bytes += target.name.size() + all(target.positions, target.normals);
    return bytes;
}

}  // namespace occam::import
