#include "lod/clusters.h"

#include <algorithm>
#include <span>

#include "base/morton.h"
#include "lod/face_split.h"

namespace occam::lod {
namespace {

struct FaceVertices {
    const Cage& cage;
    const std::vector<std::uint32_t>& first;
    std::span<const std::uint32_t> of(std::uint32_t face) const
    {
        const std::uint32_t begin = first.empty() ? face * 3 : first[face];
        const std::uint32_t end = first.empty() ? begin + 3 : first[face + 1];
        return {cage.face_vertices.data() + begin, end - begin};
    }
};

}  // namespace

ClusterTree::ClusterTree(const Cage& cage)
{
    const auto faces = static_cast<std::uint32_t>(cage.face_count());
    if (cage.scheme != Scheme::Triangles) {
        first_corner_.push_back(0);
        for (const std::uint32_t n : cage.face_sizes) first_corner_.push_back(first_corner_.back() + n);
    }
    nodes_.push_back({{}, 0, faces, 0});
    if (cage.scheme == Scheme::Triangles) part_by_area(cage);
    else halve_along_curve(cage);
    refit(cage);
}

void ClusterTree::part_by_area(const Cage& cage)
{
    constexpr int kMostDepth = 40;  // deeper nodes are halved instead of split by area
    std::vector<BoxedFace> faces(cage.face_count());
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        faces[f].face = f;
        for (std::size_t c = 0; c < 3; ++c) faces[f].box.add(cage.positions[cage.face_vertices[std::size_t(f) * 3 + c]]);
    }
    std::vector<std::uint8_t> depths{0};
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
        const auto [begin, end] = std::pair(nodes_[i].begin, nodes_[i].end);
        if (end - begin <= kMeshFaces) continue;
        const std::uint32_t most = depths[i] < kMostDepth ? end - begin : (end - begin + 1) / 2;
        const FaceSplit split = split_faces(std::span(faces).subspan(begin, end - begin), most);
        const std::uint32_t middle = begin + static_cast<std::uint32_t>(split.count);
        nodes_[i].left = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({{}, begin, middle, 0});
        nodes_.push_back({{}, middle, end, 0});
        depths.insert(depths.end(), 2, static_cast<std::uint8_t>(std::min<int>(depths[i], kMostDepth) + 1));
    }
    order_.resize(faces.size());
    for (std::size_t k = 0; k < faces.size(); ++k) order_[k] = faces[k].face;
}

void ClusterTree::halve_along_curve(const Cage& cage)
{
    const auto faces = static_cast<std::uint32_t>(cage.face_count());
    const FaceVertices corners{cage, first_corner_};
    const Box3d bounds = cage.bounds();
    const Vec3d scale = Vec3d(1023.0) / glm::max(bounds.extent(), Vec3d(1e-300));
    std::vector<std::uint64_t> keys(faces);
    for (std::uint32_t f = 0; f < faces; ++f) {
        Vec3d centre(0);
        const auto of = corners.of(f);
        for (const std::uint32_t v : of) centre += Vec3d(cage.positions[v]);
        const Vec3d cell = (centre / double(of.size()) - bounds.lo) * scale;
        const auto bits = [](double x) { return spread_bits(static_cast<std::uint64_t>(std::clamp(x, 0.0, 1023.0))); };
        keys[f] = (bits(cell.x) | bits(cell.y) << 1 | bits(cell.z) << 2) << 32 | f;
    }
    std::sort(keys.begin(), keys.end());
    order_.resize(faces);
    for (std::uint32_t i = 0; i < faces; ++i) order_[i] = static_cast<std::uint32_t>(keys[i]);

    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
        const auto [begin, end] = std::pair(nodes_[i].begin, nodes_[i].end);
        if (end - begin <= kLeafFaces) continue;
        const std::uint32_t middle = begin + (end - begin) / 2;
        nodes_[i].left = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({{}, begin, middle, 0});
        nodes_.push_back({{}, middle, end, 0});
    }
}

void ClusterTree::refit(const Cage& cage)
{
    std::vector<Box3f> boxes(nodes_.size());
    boxes_at(cage, cage.positions, boxes);
    for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].box = boxes[i];
}

void ClusterTree::boxes_at(const Cage& cage, std::span<const Vec3f> positions, std::span<Box3f> boxes) const
{
    const FaceVertices corners{cage, first_corner_};
    const bool is_smooth = cage.scheme == Scheme::CatmullClark;
    const auto faces = static_cast<std::uint32_t>(order_.size());

    // The control points of a smooth face are those of the faces around its corners.
    std::vector<Box3f> around(is_smooth ? positions.size() : 0);
    if (is_smooth)
        for (std::uint32_t f = 0; f < faces; ++f) {
            Box3f box;
            for (const std::uint32_t v : corners.of(f)) box.add(positions[v]);
            for (const std::uint32_t v : corners.of(f)) around[v].add(box);
        }
    for (std::uint32_t i = static_cast<std::uint32_t>(nodes_.size()); i-- > 0;) {
        const Node& node = nodes_[i];
        Box3f& box = boxes[i] = {};
        if (node.left != 0) {
            box.add(boxes[node.left]);
            box.add(boxes[node.left + 1]);
            continue;
        }
        for (std::uint32_t k = node.begin; k < node.end; ++k)
            for (const std::uint32_t v : corners.of(order_[k])) {
                if (is_smooth) box.add(around[v]);
                else box.add(positions[v]);
            }
        const Vec3f pad(1e-6f * box.largest_coordinate());
        box = {box.lo - pad, box.hi + pad};
    }
}

}  // namespace occam::lod
