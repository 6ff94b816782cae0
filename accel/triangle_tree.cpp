#include "accel/triangle_tree.h"

#include <algorithm>
#include <cfloat>
#include <limits>
#include <list>
#include <utility>

#include "accel/triangle_part.h"

namespace occam::accel {
namespace {

constexpr int kWidth = TriangleNode::kWidth;
constexpr std::size_t kTriangles = TriangleBlock::kTriangles;
// Share of the igrid's area from which on the overlap of two parts is large. Meshes without long triangles have few parts
// that overlap so much; of what a share of 0.05 saves where triangles are long, this one saves four fifths or more.
constexpr float kOverlap = 0.2f;
constexpr float kWorthIt = 0.9f;  // a split in space pays below this share of the cost without it
constexpr float kPartPad = 0x1p-10f;
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

}  // namespace

Box3f TriangleTree::bounds(int key) const noexcept { return box_of(nodes[std::size_t(key) * node_count]); }

// A part of a node's triangles.
struct TriangleTreeBuilder::Part {
    std::span<lod::BoxedFace> faces;
    Box3f box;
    float area = 0;
    bool may_split = false;

    Part() = default;
    explicit Part(std::span<lod::BoxedFace> all) noexcept : faces(all), may_split(all.size() > 1)
    {
        for (const lod::BoxedFace& face : all) box.add(face.box);
        area = box.half_area();
    }
    float cost() const noexcept { return area * blocks_of(faces.size()); }
};

bool TriangleTreeBuilder::split(Part& part, Part& other, int depth, std::list<SpatialParts>& made)
{
    const std::span<lod::BoxedFace> whole = part.faces;
    const bool is_deep = depth >= TriangleTree::kMostAreaDepth;
    const lod::FaceSplit split = lod::split_faces(whole, is_deep ? (whole.size() + 1) / 2 : whole.size() - 1);
    Part first(whole.first(split.count)), second(whole.subspan(split.count));
    const Box3f common{glm::max(first.box.lo, second.box.lo), glm::min(first.box.hi, second.box.hi)};
    if (!is_deep && spare_ > 0 && !common.is_empty() && common.half_area() > overlap_) {
        SpatialParts& parts = made.emplace_back();
        const float cost = std::min(part.cost(), first.cost() + second.cost());
        if (split_in_space(whole, corners_, kWorthIt * cost, spare_, parts)) {
            spare_ -= parts.below.size() + parts.above.size() - whole.size();
            part = Part(parts.below);
            other = Part(parts.above);
            return true;
        }
        made.pop_back();
    }
    if (!split.pays && whole.size() <= kTriangles) return false;
    part = first;
    other = second;
    return true;
}

std::uint32_t TriangleTreeBuilder::add_node(std::span<lod::BoxedFace> faces, int depth)
{
    Part parts[kWidth];
    std::list<SpatialParts> made;
    int count = 1;
    parts[0] = Part(faces);
    while (count < kWidth) {
        Part* largest = nullptr;
        for (int i = 0; i < count; ++i)
            if (parts[i].may_split && (!largest || parts[i].area > largest->area)) largest = &parts[i];
        if (!largest) break;
        if (split(*largest, parts[count], depth, made)) ++count;
        else largest->may_split = false;
    }
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{}, count});
    for (int i = 0; i < count; ++i) {
        std::uint32_t child = TriangleNode::kIsBlock | static_cast<std::uint32_t>(blocks_.size());
        if (parts[i].faces.size() > kTriangles) child = add_node(parts[i].faces, depth + 1);
        else {
            blocks_.push_back(
                {static_cast<std::uint32_t>(references_.size()), static_cast<std::uint32_t>(parts[i].faces.size())});
            references_.insert(references_.end(), parts[i].faces.begin(), parts[i].faces.end());
        }
        nodes_[at].children[i] = child;
    }
    return at;
}

// The box of a part of a triangle is grown by 2^-10 of the triangle's extent, so that rounding does not decide a hit:
//
// - A ray hits a triangle if it passes a triangle whose corners are a few ulps of their distance from the ray's origin aside
//   (accel/triangle.h). It passes that one in some part. What the distance of the ray's origin adds, the tests of boxes
//   allow for (accel/in_box.h); what the corners' distance from the part adds is a few ulps of the triangle's extent.
// - The distance at which it hits is that of a point of the triangle which is off the ray by eps times the triangle's
//   extent over its width, as shares of the extent: such is the rounding of the corners' shares. Triangles that are narrower
//   than 2^-11 of their length are not cut (accel/spatial_split.cpp), so this point is in the part's grown box, too, and a
//   box that a nearer hit hides holds no hit before that one.
//
// A part's box is never larger than that of the triangle.
void TriangleTreeBuilder::add_box(const lod::BoxedFace& reference, std::span<Box3f> boxes) const
{
    const auto box_of_three = [](const Vec3f* corners) {
        Box3f box;
        for (int p = 0; p < 3; ++p) box.add(corners[p]);
        return box;
    };
    const Box3f middle = box_of_three(corners_.of(reference.face));
    if (middle.lo == reference.box.lo && middle.hi == reference.box.hi) {
        for (std::size_t key = 0; key < boxes.size(); ++key) boxes[key].add(box_of_three(corners_at(reference.face, key)));
        return;
    }
    TrianglePart part(corners_.of(reference.face));
    part.cut_to(reference.box);
    float extent = 0;
    for (std::size_t key = 0; key < boxes.size(); ++key) {
        const Vec3f e = box_of_three(corners_at(reference.face, key)).extent();
        extent = std::max(extent, std::max(e.x, std::max(e.y, e.z)));
    }
    const Vec3f pad(extent * kPartPad);
    for (std::size_t key = 0; key < boxes.size(); ++key) {
        const Box3f whole = box_of_three(corners_at(reference.face, key));
        const Box3f own = part.box_at(corners_at(reference.face, key));
        boxes[key].add(Box3f{glm::max(whole.lo, own.lo - pad), glm::min(whole.hi, own.hi + pad)});
    }
}

// A block's box at each key is grown by 2 ulps of its triangles' largest coordinate or, because positions between keys are
// rounded too, by 4 ulps of the largest one of all keys.
void TriangleTreeBuilder::box_block(const Block& block, std::span<Box3f> boxes) const
{
    float largest = 0;
    for (std::size_t key = 0; key < boxes.size(); ++key) {
        boxes[key] = {};
        Box3f whole;
        for (const lod::BoxedFace& reference : of(block))
            for (int p = 0; p < 3; ++p) whole.add(corners_at(reference.face, key)[p]);
        largest = std::max(largest, whole.largest_coordinate());
    }
    for (const lod::BoxedFace& reference : of(block)) add_box(reference, boxes);
    const Vec3f pad(largest * FLT_EPSILON * (boxes.size() == 1 ? 2.0f : 4.0f));
    for (Box3f& box : boxes) box = {box.lo - pad, box.hi + pad};
}

void TriangleTreeBuilder::set_boxes(const TriangleTree& tree, std::span<TriangleNode> nodes, int keys) const
{
    std::vector<Box3f> boxes(static_cast<std::size_t>(keys));
    // Children come after their parents.
    for (std::uint32_t n = tree.node_count; n-- > 0;)
        for (int i = 0; i < kWidth; ++i) {
            const bool is_spare = i >= nodes_[n].count;
            // No ray enters a spare box. One whose numbers are NaN may seem to, and must not go around in a circle.
            const std::uint32_t child = is_spare ? TriangleNode::kIsBlock : nodes_[n].children[i];
            const bool is_block = !is_spare && TriangleNode::is_block(child);
            if (is_block) box_block(blocks_[TriangleNode::block_of(child)], boxes);
            for (std::size_t key = 0; key < boxes.size(); ++key) {
                const std::size_t first = key * tree.node_count;
                const Box3f box = is_spare ? kNothing : is_block ? boxes[key] : box_of(nodes[first + child]);
                set_box(nodes[first + n], i, box);
                nodes[first + n].children[i] = child;
            }
        }
}

// Triangles that move are divided by where they are at mid-shutter.
void TriangleTreeBuilder::set_middle(std::span<const Vec3f> corners, int keys)
{
    const std::size_t of_a_key = corners.size() / static_cast<std::size_t>(keys);
    corners_ = {corners.subspan(of_a_key * static_cast<std::size_t>((keys - 1) / 2), of_a_key), corners};
    if (keys == 2) {
        middle_.resize(of_a_key);
        for (std::size_t i = 0; i < of_a_key; ++i) middle_[i] = 0.5f * corners[i] + 0.5f * corners[of_a_key + i];
        corners_.middle = middle_;
    }
    boxed_.resize(of_a_key / 3);
    Box3f all;
    for (std::uint32_t f = 0; f < boxed_.size(); ++f) {
        boxed_[f] = {{}, f};
        for (int p = 0; p < 3; ++p) boxed_[f].box.add(corners_.of(f)[p]);
        all.add(boxed_[f].box);
    }
    overlap_ = all.half_area() * kOverlap;
    spare_ = splits_in_space ? boxed_.size() * TriangleTree::kMostQuarters / 4 - boxed_.size() : 0;
}

TriangleTree TriangleTreeBuilder::build(std::span<const std::uint32_t> faces, std::span<const Vec3f> corners, int keys,
                                        Arena& arena)
{
    nodes_.clear();
    blocks_.clear();
    references_.clear();
    set_middle(corners, keys);
    add_node(boxed_, 0);
    const auto all_keys = static_cast<std::size_t>(keys);
    const std::span<TriangleNode> nodes = arena.make_array<TriangleNode>(nodes_.size() * all_keys);
    const std::span<TriangleBlock> blocks = arena.make_array<TriangleBlock>(blocks_.size() * all_keys);
    const std::span<std::uint32_t> face_of = arena.make_array<std::uint32_t>(blocks_.size() * kTriangles);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
        for (std::size_t i = 0; i < kTriangles; ++i) {
            const bool is_spare = i >= blocks_[b].count;
            const std::size_t number = is_spare ? 0 : of(blocks_[b])[i].face;
            face_of[b * kTriangles + i] = is_spare ? face_of[b * kTriangles + i - 1] : faces[number];
            for (std::size_t key = 0; key < all_keys; ++key)
                for (std::size_t c = 0; c < 9; ++c)
                    blocks[key * blocks_.size() + b].corners[c][i] =
                        is_spare ? std::numeric_limits<float>::quiet_NaN()
                                 : corners[3 * (key * faces.size() + number) + c / 3][static_cast<int>(c % 3)];
        }
    const TriangleTree tree{static_cast<std::uint32_t>(nodes_.size()), static_cast<std::uint32_t>(blocks_.size()),
                            nodes.data(), blocks.data(), face_of.data()};
    set_boxes(tree, nodes, keys);
    return tree;
}

}  // namespace occam::accel
