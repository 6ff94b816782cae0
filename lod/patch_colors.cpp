#include "lod/patch_colors.h"

namespace occam::lod {

PatchColors::PatchColors(const PosedCage& posed, PatchRef patch) noexcept
{
    const Cage& cage = posed.slot->cage;
    const std::uint32_t first = posed.topology->first_corner(patch.face), size = posed.topology->face_size(patch.face);
    const std::vector<std::uint32_t>& indices = cage.color_indices.empty() ? cage.face_vertices : cage.color_indices;
    const auto color = [&](std::uint32_t k) { return cage.colors[indices[first + k % size]]; };
    if (size == 4) {
        for (std::uint32_t k = 0; k < 4; ++k) corner_[k] = color(k);
        return;
    }
    Vec4f sum(0);
    for (std::uint32_t k = 0; k < size; ++k) sum += color(k);
    corner_[0] = color(patch.sub);
    corner_[1] = (corner_[0] + color(patch.sub + 1)) * 0.5f;
    corner_[2] = sum / float(size);
    corner_[3] = (corner_[0] + color(patch.sub + size - 1)) * 0.5f;
}

}  // namespace occam::lod
