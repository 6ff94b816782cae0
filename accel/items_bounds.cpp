// The boxes of items and of their igrids, in the frame of the tree.
#include "accel/items.h"

namespace occam::accel {
namespace {

/// Returns how far a ray may be from where it is in the world, in world length, after it was taken to a still pose: its
/// origin lies within some radii there, and its direction is rounded, too.
double rounding_of(const lod::PosedCage& still_pose)
{
    return double(still_pose.radius) * still_pose.affine->stretch() * 0x1p-18;
}

}  // namespace

Box3f Items::to_tree(const lod::PosedCage& cage, int key, const Box3f& box) const
{
    const Vec3d shift = cage.at_key(key).anchor - frame_.anchor;
    const double pad = cage.still_pose ? rounding_of(*cage.still_pose) : 0;
    return outward_float({Vec3d(box.lo) + shift - pad, Vec3d(box.hi) + shift + pad}, Vec3d(0), kBoxUlps);
}

Box3f Items::to_tree(const Box3d& world, double pad) const
{
    if (world.is_empty()) return {};
    return outward_float({world.lo - pad, world.hi + pad}, frame_.anchor, kBoxUlps);
}

Box3f Items::box_of(const lod::PosedCage& cage, std::uint32_t cluster) const
{
    return to_tree(cage.world_box(cluster), cage.radius * kVertexRounding);
}

void Items::set_boxes(ShutterBox& to, std::span<const Box3f> own)
{
    to.at_keys = nullptr;
    to.box = own.front();
    if (own.size() == 1) return;
    for (const Box3f& box : own) to.box.add(box);
    if (to.box.is_empty()) return;
    GrowthAtKeys growth;
    const std::span<Box3f> boxes = arena_.make_array<Box3f>(static_cast<std::size_t>(frame_.segments) + 1);
    for (std::size_t k = 0; k < boxes.size(); ++k) {
        const lod::KeyTime at = lod::key_time(float(k) / float(frame_.segments), static_cast<int>(own.size()) - 1);
        const Box3f &a = own[static_cast<std::size_t>(at.key)], &b = own[static_cast<std::size_t>(at.key) + 1];
        const Box3f box{glm::mix(a.lo, b.lo, at.share), glm::mix(a.hi, b.hi, at.share)};
        const Vec3f pad(growth.next(box));
        boxes[k] = {box.lo - pad, box.hi + pad};
        to.box.add(boxes[k]);
    }
    to.at_keys = boxes.data();
}

Box3f Items::image_in_tree(const IGrid& grid, const lod::AffinePose& pose) const
{
    const Box3f still = grid.bounds();
    if (still.is_empty()) return {};
    Box3d image;
    for (int corner = 0; corner < 8; ++corner)
        image.add(pose.anchor + pose.apply({corner & 1 ? still.hi.x : still.lo.x, corner & 2 ? still.hi.y : still.lo.y,
                                            corner & 4 ? still.hi.z : still.lo.z}));
    return to_tree(image, rounding_of(*grid.cage));
}

Box3f Items::box_at(const IGrid& grid, float time) const
{
    if (grid.cage->affine) return image_in_tree(grid, grid.cage->affine->at(time));
    if (grid.segments == 0) return to_tree(*grid.cage, 0, grid.bounds());
    const lod::KeyTime at = lod::key_time(time, grid.segments);
    const Box3f a = grid.bounds_at_key(at.key), b = grid.bounds_at_key(at.key + 1);
    if (a.is_empty() || b.is_empty()) return {};
    return to_tree(*grid.cage, at.key, {glm::mix(a.lo, b.lo, at.share), glm::mix(a.hi, b.hi, at.share)});
}

GridBounds Items::bounds_of(const IGrid& grid) const
{
    if (grid.cage->affine) {
        Box3f all;
        for (int key = 0; key <= grid.cage->affine->segments(); ++key)
            all.add(image_in_tree(grid, grid.cage->affine->key(key)));
        return {all, {}};
    }
    const Box3f box = to_tree(*grid.cage, 0, grid.bounds());
    const float off = slab_rounding(box.largest_coordinate() + grid.cage->radius);
    const auto shift = static_cast<float>(glm::dot(Vec3d(grid.slab.normal), grid.cage->anchor - frame_.anchor));
    return {box, {grid.slab.normal, grid.slab.lo + shift - off, grid.slab.hi + shift + off}};
}

}  // namespace occam::accel
