#include "accel/triangle_tree.h"

#include <algorithm>
#include <cfloat>
#include <limits>

namespace occam::accel {
namespace {

constexpr int kWidth = TriangleNode::kWidth;
constexpr std::size_t kTriangles = TriangleBlock::kTriangles;
// An empty box. It is finite, so that it is linear between keys.
constexpr Box3f kNothing{Vec3f(FLT_MAX), Vec3f(-FLT_MAX)};

void set_box(TriangleNode& node, int i, const Box3f& box) noexcept
{
    for (int a = 0; a < 3; ++a) {
        node.boxes[a * kWidth + i] = box.lo[a];
        node.boxes[(a + 3) * kWidth + i] = box.hi[a];
    }
}

Box3f box_of(const TriangleNode& node) noexcept
{
    Box3f box;
    for (int i = 0; i < kWidth; ++i)
        for (int a = 0; a < 3; ++a) {
            box.lo[a] = std::min(box.lo[a], node.boxes[a * kWidth + i]);
            box.hi[a] = std::max(box.hi[a], node.boxes[(a + 3) * kWidth + i]);
        }
    return box;
}

// A part of a node's triangles.
struct Part {
    std::span<lod::BoxedFace> faces;
    float area = 0;
    bool may_split = false;

    Part() = default;
    explicit Part(std::span<lod::BoxedFace> all) noexcept : faces(all), may_split(all.size() > 1)
    {
        Box3f box;
        for (const lod::BoxedFace& face : all) box.add(face.box);
        area = box.half_area();
    }
};

}  // namespace

Box3f TriangleTree::bounds(int key) const noexcept { return box_of(nodes[std::size_t(key) * node_count]); }

std::uint32_t TriangleTreeBuilder::add_node(std::span<lod::BoxedFace> faces, int depth)
{
    Part parts[kWidth];
    int count = 1;
    parts[0] = Part(faces);
    while (count < kWidth) {
        Part* largest = nullptr;
        for (int i = 0; i < count; ++i)
            if (parts[i].may_split && (!largest || parts[i].area > largest->area)) largest = &parts[i];
        if (!largest) break;
        const std::span<lod::BoxedFace> whole = largest->faces;
        const std::size_t most = depth < TriangleTree::kMostAreaDepth ? whole.size() - 1 : (whole.size() + 1) / 2;
        const lod::FaceSplit split = lod::split_faces(whole, most);
        if (!split.pays && whole.size() <= kTriangles) {
            largest->may_split = false;
            continue;
        }
        *largest = Part(whole.first(split.count));
        parts[count++] = Part(whole.subspan(split.count));
    }
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{}, count});
    for (int i = 0; i < count; ++i) {
        std::uint32_t child = TriangleNode::kIsBlock | static_cast<std::uint32_t>(blocks_.size());
        if (parts[i].faces.size() > kTriangles) child = add_node(parts[i].faces, depth + 1);
        else blocks_.push_back(parts[i].faces);
        nodes_[at].children[i] = child;
    }
    return at;
}

// A block's box at each key is grown by 2 ulps of its largest coordinate or, because positions between keys are rounded too,
// by 4 ulps of the largest one of all keys.
void TriangleTreeBuilder::set_boxes(const TriangleTree& tree, std::span<TriangleNode> nodes, std::span<const Vec3f> corners,
                                    int keys) const
{
    const std::size_t of_a_key = corners.size() / static_cast<std::size_t>(keys);
    const auto box_at = [&](std::uint32_t block, int key) {
        Box3f box;
        for (const lod::BoxedFace& face : blocks_[block])
            for (std::size_t p = 0; p < 3; ++p) box.add(corners[std::size_t(key) * of_a_key + 3 * face.face + p]);
        return box;
    };
    // Children come after their parents.
    for (std::uint32_t n = tree.node_count; n-- > 0;)
        for (int i = 0; i < kWidth; ++i) {
            const bool is_spare = i >= nodes_[n].count;
            // No ray enters a spare box. One whose numbers are NaN may seem to, and must not go around in a circle.
            const std::uint32_t child = is_spare ? TriangleNode::kIsBlock : nodes_[n].children[i];
            const bool is_block = !is_spare && TriangleNode::is_block(child);
            float pad = 0;
            for (int key = 0; is_block && key < keys; ++key)
                pad = std::max(pad, box_at(TriangleNode::block_of(child), key).largest_coordinate() * FLT_EPSILON *
                                        (keys == 1 ? 2.0f : 4.0f));
            for (int key = 0; key < keys; ++key) {
                const std::size_t first = std::size_t(key) * tree.node_count;
                Box3f box = kNothing;
                if (is_block) {
                    box = box_at(TriangleNode::block_of(child), key);
                    box = {box.lo - Vec3f(pad), box.hi + Vec3f(pad)};
                } else if (!is_spare) {
                    box = box_of(nodes[first + child]);
                }
                set_box(nodes[first + n], i, box);
                nodes[first + n].children[i] = child;
            }
        }
}

TriangleTree TriangleTreeBuilder::build(std::span<lod::BoxedFace> boxed, std::span<const std::uint32_t> faces,
                                        std::span<const Vec3f> corners, int keys, Arena& arena)
{
    nodes_.clear();
    blocks_.clear();
    add_node(boxed, 0);
    const auto all_keys = static_cast<std::size_t>(keys);
    const std::span<TriangleNode> nodes = arena.make_array<TriangleNode>(nodes_.size() * all_keys);
    const std::span<TriangleBlock> blocks = arena.make_array<TriangleBlock>(blocks_.size() * all_keys);
    const std::span<std::uint32_t> face_of = arena.make_array<std::uint32_t>(blocks_.size() * kTriangles);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
        for (std::size_t i = 0; i < kTriangles; ++i) {
            const bool is_spare = i >= blocks_[b].size();
            const std::size_t number = is_spare ? 0 : blocks_[b][i].face;
            face_of[b * kTriangles + i] = is_spare ? face_of[b * kTriangles + i - 1] : faces[number];
            for (std::size_t key = 0; key < all_keys; ++key)
                for (std::size_t c = 0; c < 9; ++c)
                    blocks[key * blocks_.size() + b].corners[c][i] =
                        is_spare ? std::numeric_limits<float>::quiet_NaN()
                                 : corners[3 * (key * faces.size() + number) + c / 3][static_cast<int>(c % 3)];
        }
    const TriangleTree tree{static_cast<std::uint32_t>(nodes_.size()), static_cast<std::uint32_t>(blocks_.size()),
                            nodes.data(), blocks.data(), face_of.data()};
    set_boxes(tree, nodes, corners, keys);
    return tree;
}

}  // namespace occam::accel
