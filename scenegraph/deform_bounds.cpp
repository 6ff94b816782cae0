#include "scenegraph/deform_bounds.h"

#include <algorithm>

namespace occam {

Box3d morph_extent(std::span<const Box3f> offsets, std::span<const float> weights) noexcept
{
    Box3d extent{Vec3d(0), Vec3d(0)};
    for (std::size_t k = 0; k < std::min(offsets.size(), weights.size()); ++k) {
        if (offsets[k].is_empty() || weights[k] == 0) continue;
        const Vec3d a = Vec3d(offsets[k].lo) * double(weights[k]), b = Vec3d(offsets[k].hi) * double(weights[k]);
        extent.lo += glm::min(a, b);
        extent.hi += glm::max(a, b);
    }
    return extent;
}

void DeformBoundsTable::begin(const Cage& cage)
{
    targets_ = cage.morph_targets.size();
    parts_.push_back({{}, static_cast<std::uint32_t>(joints_.size()), 0, static_cast<std::uint32_t>(offsets_.size())});
    offsets_.resize(offsets_.size() + targets_);
}

void DeformBoundsTable::add_vertex(const Cage& cage, std::uint32_t v)
{
    PartRecord& part = parts_.back();
    const Vec3f p = cage.positions[v];
    part.rest.add(p);
    for (int set = 0; set < cage.skin.sets; ++set) {
        const std::size_t at = std::size_t(set) * cage.positions.size() + v;
        for (int k = 0; k < 4; ++k) {
            if (!(cage.skin.weights[at][k] > 0)) continue;
            add_to_joint(cage.skin.joints[at][k], {p, p});
        }
    }
    for (std::size_t t = 0; t < targets_; ++t)
        if (!cage.morph_targets[t].positions.empty())
            offsets_[part.first_offset + t].add(cage.morph_targets[t].positions[v]);
}

void DeformBoundsTable::add_to_joint(std::uint16_t joint, const Box3f& box)
{
    if (joint >= scratch_.size()) scratch_.resize(joint + std::size_t(1));
    if (scratch_[joint].is_empty()) touched_.push_back(joint);
    scratch_[joint].add(box);
}

void DeformBoundsTable::finish()
{
    std::ranges::sort(touched_);
    for (const std::uint16_t joint : touched_) {
        joints_.push_back({joint, scratch_[joint]});
        scratch_[joint] = {};
    }
    touched_.clear();
    parts_.back().joint_count = static_cast<std::uint32_t>(joints_.size()) - parts_.back().first_joint;
}

void DeformBoundsTable::add(const Cage& cage, std::span<const std::uint32_t> vertices)
{
    begin(cage);
    for (const std::uint32_t v : vertices) add_vertex(cage, v);
    finish();
}

void DeformBoundsTable::add_all(const Cage& cage, std::span<const std::uint32_t> without)
{
    begin(cage);
    for (std::uint32_t v = 0; v < cage.positions.size(); ++v) {
        if (without.empty() || without.front() != v) add_vertex(cage, v);
        else without = without.subspan(1);
    }
    finish();
}

void DeformBoundsTable::add_union(std::size_t a, std::size_t b)
{
    PartRecord whole{parts_[a].rest, static_cast<std::uint32_t>(joints_.size()), 0,
                     static_cast<std::uint32_t>(offsets_.size())};
    whole.rest.add(parts_[b].rest);
    for (const std::size_t part : {a, b})
        for (std::uint32_t j = 0; j < parts_[part].joint_count; ++j) {
            const JointBox& of = joints_[parts_[part].first_joint + j];
            add_to_joint(of.joint, of.box);
        }
    for (std::size_t t = 0; t < targets_; ++t) {
        Box3f box = offsets_[parts_[a].first_offset + t];
        box.add(offsets_[parts_[b].first_offset + t]);
        offsets_.push_back(box);
    }
    parts_.push_back(whole);
    finish();
}

DeformBounds DeformBoundsTable::operator[](std::size_t part) const noexcept
{
    const PartRecord& p = parts_[part];
    return {p.rest, {joints_.data() + p.first_joint, p.joint_count}, {offsets_.data() + p.first_offset, targets_}};
}

}  // namespace occam
