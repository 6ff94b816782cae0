#include "scenegraph/cage.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/error_without_file.h"
#include "scenegraph/cage_creases.h"
#include "scenegraph/content_rules.h"

namespace occam {

namespace {

bool is_finite(Vec2f p) noexcept { return std::isfinite(p.x) && std::isfinite(p.y); }
bool is_finite(Vec4f p) noexcept
{
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && std::isfinite(p.w);
}

class Mending {
public:
    explicit Mending(Cage& cage) : cage_(cage) {}

    std::vector<std::string> run()
    {
        check_sizes();
        mend_positions();
        mend_faces();
        mend_tags();
        report(drop_creases_of_two_faces(cage_), "creases dropped: at a vertex of two faces");
        mend_normals();
        mend_attributes();
        mend_skin();
        mend_displacement();
        return std::move(lines_);
    }

private:
    void report(std::size_t count, const char* what)
    {
        if (count > 0) lines_.push_back(std::to_string(count) + " " + what);
    }
    void require(bool holds, const char* rule) const
    {
        if (!holds) throw error_without_file(rule, naming("cage", cage_.name));
    }

    void check_sizes() const
    {
        constexpr std::size_t kMaxIndex = 0x7fffffff;  // OpenSubdiv's indices are int
        const std::size_t vertices = cage_.positions.size(), corners = cage_.face_vertices.size();
        require(vertices < kMaxIndex && corners < kMaxIndex, "more than 2^31 vertices or corners");
        if (cage_.scheme == Scheme::Triangles) {
            require(cage_.face_sizes.empty(), "face_sizes must be empty for triangles");
            require(corners % 3 == 0, "the number of face vertices must be a multiple of three for triangles");
        } else {
            std::size_t sum = 0;
            for (std::uint32_t size : cage_.face_sizes) sum += size;
            require(sum == corners, "face_vertices must have one entry a face corner");
        }
        require(cage_.normals.empty() || cage_.normals.size() == vertices, "normals must have one entry a vertex");
        require(cage_.color_indices.empty() ? cage_.colors.empty() || cage_.colors.size() == vertices
                                            : cage_.color_indices.size() == corners,
                "colors must have one entry a vertex or one index a face corner");
        require(cage_.face_slots.empty() || cage_.face_slots.size() == cage_.face_count(),
                "face_slots must have one entry a face");
        for (const UvSet& set : cage_.uv_sets)
            require(set.indices.empty() ? set.values.size() == vertices : set.indices.size() == corners,
                    "a UV set must have one value a vertex or one index a face corner");
        for (const MorphTarget& target : cage_.morph_targets)
            require((target.positions.empty() || target.positions.size() == vertices) &&
                        (target.normals.empty() || target.normals.size() == vertices),
                    "a morph target must have one offset a vertex");
        require(cage_.skin.sets >= 0 && cage_.skin.joints.size() == cage_.skin.weights.size() &&
                    cage_.skin.joints.size() == std::size_t(cage_.skin.sets) * vertices,
                "a skin binding must have one entry a vertex and set");
    }

    // Moves each vertex that cannot be used onto a usable one, so that bounds stay right. Its faces are dropped later.
    void mend_positions()
    {
        std::vector<Vec3f>& positions = cage_.positions;
        const auto usable = std::find_if(positions.begin(), positions.end(), is_usable);
        const Vec3f stand_in = usable != positions.end() ? *usable : Vec3f(0);
        std::size_t count = 0;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            if (is_usable(positions[i])) continue;
            if (unusable_.empty()) unusable_.resize(positions.size());
            unusable_[i] = true;
            positions[i] = stand_in;
            ++count;
        }
        report(count, "vertices are not finite or beyond 1e16");
    }

    // So many faces may share a vertex of a cage that is no triangle mesh.
    static constexpr std::uint32_t kMaxSubdividedValence = 4096;

    enum class Verdict { Keep, Collapse, OutOfRange, Unusable, Degenerate, TooLarge, AtPole };
    static constexpr std::size_t kVerdicts = static_cast<std::size_t>(Verdict::AtPole) + 1;

    Verdict judge(std::span<const std::uint32_t> face, std::uint32_t stamp)
    {
        if (face.size() > kMaxFaceCorners) return Verdict::TooLarge;
        for (std::uint32_t v : face)
            if (v >= cage_.positions.size()) return Verdict::OutOfRange;
        if (!unusable_.empty())
            for (std::uint32_t v : face)
                if (unusable_[v]) return Verdict::Unusable;
        std::size_t different = 0;
        bool is_twice_apart = false;
        for (std::size_t c = 0; c < face.size(); ++c) {
            const std::uint32_t before = face[c == 0 ? face.size() - 1 : c - 1];
            if (face[c] == before && face.size() > 1) continue;
            ++different;
            // A run of equal corners that goes over the end of the face is skipped at its beginning, by `before` above.
            is_twice_apart |= stamp_of_[face[c]] == stamp;
            stamp_of_[face[c]] = stamp;
        }
        if (different < 3 || is_twice_apart) return Verdict::Degenerate;
        return different == face.size() ? Verdict::Keep : Verdict::Collapse;
    }

    // Checks the common case in one pass without a table.
    bool are_good_triangles() const
    {
        if (cage_.scheme != Scheme::Triangles || !unusable_.empty()) return false;
        const std::uint32_t vertices = static_cast<std::uint32_t>(cage_.positions.size());
        bool good = true;
        for (std::size_t c = 0; c < cage_.face_vertices.size(); c += 3) {
            const std::uint32_t v0 = cage_.face_vertices[c], v1 = cage_.face_vertices[c + 1],
                                v2 = cage_.face_vertices[c + 2];
            good &= (std::max({v0, v1, v2}) < vertices) & (v0 != v1) & (v1 != v2) & (v2 != v0);
        }
        return good;
    }

    void mend_faces()
    {
        if (are_good_triangles()) return;
        const bool triangles = cage_.scheme == Scheme::Triangles;
        const std::size_t faces = cage_.face_count();
        stamp_of_.assign(cage_.positions.size(), 0);
        std::size_t counts[kVerdicts] = {};
        std::vector<Verdict> verdicts(faces);
        for (std::size_t f = 0, at = 0; f < faces; ++f) {
            const std::size_t size = triangles ? 3 : cage_.face_sizes[f];
            const auto face = std::span(cage_.face_vertices).subspan(at, size);
            verdicts[f] = judge(face, static_cast<std::uint32_t>(f + 1));
            if (triangles && verdicts[f] == Verdict::Collapse) verdicts[f] = Verdict::Degenerate;
            at += size;
        }
        drop_poles(verdicts);
        for (const Verdict verdict : verdicts) ++counts[static_cast<int>(verdict)];
        if (counts[0] != faces) keep_faces(verdicts);
        report(counts[static_cast<int>(Verdict::Collapse)], "faces lost corners that repeat their neighbour");
        report(counts[static_cast<int>(Verdict::OutOfRange)], "faces dropped: a vertex index is out of range");
        report(counts[static_cast<int>(Verdict::Unusable)], "faces dropped: a vertex is not finite");
        report(counts[static_cast<int>(Verdict::Degenerate)],
               "faces dropped: degenerate (fewer than three vertices, or one twice)");
        report(counts[static_cast<int>(Verdict::TooLarge)], "faces dropped: more than 4096 corners");
        report(counts[static_cast<int>(Verdict::AtPole)],
               "faces dropped: more than 4096 of them meet at a vertex, which cannot be subdivided");
    }

    // Drops the faces around each vertex that too many faces of a subdivided cage share.
    void drop_poles(std::vector<Verdict>& verdicts) const
    {
        if (cage_.scheme == Scheme::Triangles) return;
        const auto for_kept = [&](auto&& visit) {
            std::size_t at = 0;
            for (std::size_t f = 0; f < verdicts.size(); at += cage_.face_sizes[f], ++f)
                if (verdicts[f] == Verdict::Keep || verdicts[f] == Verdict::Collapse)
                    visit(verdicts[f], std::span(cage_.face_vertices).subspan(at, cage_.face_sizes[f]));
        };
        std::vector<std::uint32_t> valence(cage_.positions.size());
        for_kept([&](Verdict, std::span<const std::uint32_t> face) {
            for (const std::uint32_t v : face) ++valence[v];
        });
        if (std::none_of(valence.begin(), valence.end(), [](std::uint32_t n) { return n > kMaxSubdividedValence; })) return;
        for_kept([&](Verdict& verdict, std::span<const std::uint32_t> face) {
            for (const std::uint32_t v : face)
                if (valence[v] > kMaxSubdividedValence) verdict = Verdict::AtPole;
        });
    }

    // Moves the faces that are kept to the front, and renumbers the holes.
    void keep_faces(const std::vector<Verdict>& verdicts)
    {
        constexpr std::uint32_t kDropped = 0xffffffff;
        const bool triangles = cage_.scheme == Scheme::Triangles;
        std::vector<std::uint32_t> new_face(verdicts.size(), kDropped);
        std::size_t from = 0, to = 0, face_to = 0;
        for (std::size_t f = 0; f < verdicts.size(); ++f) {
            const std::size_t size = triangles ? 3 : cage_.face_sizes[f], begin = from;
            from += size;
            if (verdicts[f] != Verdict::Keep && verdicts[f] != Verdict::Collapse) continue;
            const std::size_t to_begin = to;
            const std::uint32_t last = cage_.face_vertices[from - 1];
            std::uint32_t before = last;
            for (std::size_t c = begin; c < from; ++c) {
                const std::uint32_t v = cage_.face_vertices[c];
                if (v == before) continue;
                before = v;
                cage_.face_vertices[to] = v;
                for (UvSet& set : cage_.uv_sets)
                    if (!set.indices.empty()) set.indices[to] = set.indices[c];
                if (!cage_.color_indices.empty()) cage_.color_indices[to] = cage_.color_indices[c];
                ++to;
            }
            if (!triangles) cage_.face_sizes[face_to] = static_cast<std::uint32_t>(to - to_begin);
            if (!cage_.face_slots.empty()) cage_.face_slots[face_to] = cage_.face_slots[f];
            new_face[f] = static_cast<std::uint32_t>(face_to++);
        }
        cage_.face_vertices.resize(to);
        for (UvSet& set : cage_.uv_sets)
            if (!set.indices.empty()) set.indices.resize(to);
        if (!cage_.color_indices.empty()) cage_.color_indices.resize(to);
        if (!triangles) cage_.face_sizes.resize(face_to);
        if (!cage_.face_slots.empty()) cage_.face_slots.resize(face_to);
        std::vector<std::uint32_t> holes;
        for (std::uint32_t hole : cage_.holes) {
            if (hole >= new_face.size()) holes.push_back(kDropped);  // a hole out of range is counted with the other tags
            else if (new_face[hole] != kDropped) holes.push_back(new_face[hole]);
        }
        cage_.holes = std::move(holes);
    }

    void mend_tags()
    {
        const std::size_t vertices = cage_.positions.size();
        const auto is_sharpness = [](float s) { return s >= 0; };  // this is false for NaN
        std::size_t dropped = std::erase_if(cage_.creases, [&](const Crease& crease) {
            return crease.v0 >= vertices || crease.v1 >= vertices || crease.v0 == crease.v1 ||
                   !is_sharpness(crease.sharpness);
        });
        if (cage_.scheme != Scheme::Triangles) dropped += drop_creases_off_edges(cage_);
        report(dropped, "creases dropped: no such edge, or no sharpness");
        dropped = std::erase_if(cage_.corners, [&](const Corner& corner) {
            return corner.vertex >= vertices || !is_sharpness(corner.sharpness);
        });
        report(dropped, "corners dropped: no such vertex, or no sharpness");
        dropped = std::erase_if(cage_.holes, [&](std::uint32_t hole) { return hole >= cage_.face_count(); });
        report(dropped, "holes dropped: no such face");
        for (Crease& crease : cage_.creases) crease.sharpness = std::min(crease.sharpness, kInfiniteSharpness);
        for (Corner& corner : cage_.corners) corner.sharpness = std::min(corner.sharpness, kInfiniteSharpness);
        std::sort(cage_.holes.begin(), cage_.holes.end());
        cage_.holes.erase(std::unique(cage_.holes.begin(), cage_.holes.end()), cage_.holes.end());
    }

    // Replaces a normal without a direction by the mean of the triangles around its vertex, weighted by area.
    void mend_normals()
    {
        if (cage_.scheme != Scheme::Triangles) cage_.normals.clear();
        std::vector<std::uint32_t> broken;
        for (std::size_t v = 0; v < cage_.normals.size(); ++v) {
            Vec3f& n = cage_.normals[v];
            const double length = glm::length(Vec3d(n));
            if (!(length > 1e-30 && length < 1e30)) broken.push_back(static_cast<std::uint32_t>(v));
            else if (!(std::abs(length - 1) < 1e-6)) n = Vec3f(Vec3d(n) / length);
        }
        if (broken.empty()) return;
        for (std::uint32_t v : broken) cage_.normals[v] = Vec3f(0);
        std::vector<Vec3d> sums(cage_.positions.size(), Vec3d(0));
        std::vector<bool> is_used(cage_.positions.size(), false);
        for (std::size_t c = 0; c + 2 < cage_.face_vertices.size(); c += 3) {
            const std::uint32_t* t = &cage_.face_vertices[c];
            const Vec3d a(cage_.positions[t[0]]), b(cage_.positions[t[1]]), d(cage_.positions[t[2]]);
            const Vec3d area = glm::cross(b - a, d - a);
            for (int k = 0; k < 3; ++k) sums[t[k]] += area, is_used[t[k]] = true;
        }
        for (std::uint32_t v : broken) {
            const double length = glm::length(sums[v]);
            cage_.normals[v] = length > 0 ? Vec3f(sums[v] / length) : Vec3f(0, 1, 0);
        }
        // Nobody misses the normal of a vertex that no face uses.
        const auto missed = std::count_if(broken.begin(), broken.end(), [&](std::uint32_t v) { return is_used[v]; });
        report(static_cast<std::size_t>(missed), "normals had no direction");
    }

    void mend_attributes()
    {
        std::size_t count = 0;
        for (UvSet& set : cage_.uv_sets) {
            for (Vec2f& uv : set.values)
                if (!is_finite(uv)) uv = Vec2f(0), ++count;
            if (set.values.empty() && !set.indices.empty()) set.values.push_back(Vec2f(0));
            for (std::uint32_t& i : set.indices)
                if (i >= set.values.size()) i = 0, ++count;
        }
        report(count, "texture coordinates are not finite or out of range");
        count = 0;
        for (Vec4f& color : cage_.colors)
            if (!is_finite(color)) color = Vec4f(1), ++count;
        if (cage_.colors.empty() && !cage_.color_indices.empty()) cage_.colors.push_back(Vec4f(1));
        for (std::uint32_t& i : cage_.color_indices)
            if (i >= cage_.colors.size()) i = 0, ++count;
        report(count, "vertex colours are not finite or out of range");
        count = 0;
        const std::size_t slots = std::max<std::size_t>(1, cage_.materials.size());
        for (std::uint16_t& slot : cage_.face_slots)
            if (slot >= slots) slot = 0, ++count;
        report(count, "faces name a material slot that does not exist");
        count = 0;
        for (MorphTarget& target : cage_.morph_targets)
            for (std::vector<Vec3f>* offsets : {&target.positions, &target.normals})
                for (Vec3f& offset : *offsets)
                    if (!is_usable(offset)) offset = Vec3f(0), ++count;
        cage_.morph_weights.resize(cage_.morph_targets.size(), 0.0f);
        for (float& weight : cage_.morph_weights)
            if (!std::isfinite(weight)) weight = 0, ++count;
        report(count, "morph offsets or weights are not finite");
    }

    void mend_skin()
    {
        const std::size_t vertices = cage_.positions.size();
        std::size_t count = 0;
        for (std::size_t v = 0; cage_.skin.sets > 0 && v < vertices; ++v) {
            double sum = 0;
            for (int s = 0; s < cage_.skin.sets; ++s) {
                Vec4f& w = cage_.skin.weights[std::size_t(s) * vertices + v];
                for (int k = 0; k < 4; ++k) {
                    if (!(w[k] >= 0 && w[k] < 1e6f)) w[k] = 0, ++count;
                    sum += double(w[k]);
                }
            }
            if (sum == 0) cage_.skin.weights[v] = Vec4f(1, 0, 0, 0), sum = 1, ++count;
            if (std::abs(sum - 1) < 1e-6) continue;  // so that a cage that was mended stays as it is
            for (int s = 0; s < cage_.skin.sets; ++s) {
                Vec4f& w = cage_.skin.weights[std::size_t(s) * vertices + v];
                w = Vec4f(Vec4d(w) / sum);
            }
        }
        report(count, "skin weights are negative, not finite or all zero");
    }

    void mend_displacement()
    {
        if (!cage_.displacement) return;
        const Displacement& d = *cage_.displacement;
        const TextureUse& use = d.texture;
        const bool is_placed = is_finite(use.offset) && is_finite(use.scale) && std::isfinite(use.rotation);
        const bool is_good = is_placed && std::abs(d.scale) <= kMaxCoordinate && std::abs(d.midlevel) <= kMaxCoordinate &&
                             d.bound >= 0 && d.bound <= kMaxCoordinate;
        if (is_good) {
            if (cage_.scheme == Scheme::Triangles) report(1, "displacement is not rendered: it is a mesh of triangles");
            else if (d.texture.uv_set < 0 || static_cast<std::size_t>(d.texture.uv_set) >= cage_.uv_sets.size())
                report(1, "displacement is not rendered: the cage lacks the texture coordinates that it asks for");
            return;
        }
        cage_.displacement.reset();
        report(1, "displacement dropped: it or its texture's transform is not finite, or its bound negative");
    }

    Cage& cage_;
    std::vector<std::string> lines_;
    std::vector<bool> unusable_;           // one for each vertex; empty if all are usable
    std::vector<std::uint32_t> stamp_of_;  // for each vertex, 1 + the last face that visited it
};

}  // namespace

std::vector<std::string> sanitize(Cage& cage) { return Mending(cage).run(); }

}  // namespace occam
