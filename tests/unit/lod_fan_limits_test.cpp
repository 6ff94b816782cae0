// Tests of the limits of vertices around which the faces form several fans, against subdivision in long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lod/posed_patch.h"
#include "tests/support/campaign.h"
#include "tests/support/case_random.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/limit_oracle.h"

namespace occam::test {
namespace {

/// Holds a vertex with the faces around it, in long double, however these meet.
///
/// An edge is open unless two faces of one orientation meet there. Open edges are infinitely sharp. A vertex of one fan of
/// faces follows the rules of Catmull and Clark (1978), as limit_oracle.h has them. A vertex of several fans is a corner,
/// unless it has two open edges, of more than two faces each, each fan runs from one of these to the other, and creases that
/// become smooth in the last step are equally sharp (docs/files.md).
class FanStar {
public:
    FanStar(const Cage& cage, std::uint32_t vertex);
    Vec3l limit();

private:
    using Real = long double;
    struct Spoke {
        std::uint32_t vertex;
        Vec3l end;
        Real sharpness = 0;
        std::vector<std::size_t> begins, ends;  ///< faces that have it as `from`, and as `to`
        bool is_open() const { return begins.size() != 1 || ends.size() != 1; }
    };
    struct Face {
        std::size_t from, to;  ///< spokes
        Vec3l others{0};       ///< the sum of all other vertices but the middle one
        Real size;
    };
    enum class Rule { Smooth, Crease, Corner };

    std::size_t spoke_to(const Cage& cage, std::uint32_t vertex);
    bool is_held() const;
    bool softens_alike() const;
    Rule rule(int steps) const;
    Real sharpness_after(Real sharpness, int steps) const
    {
        return sharpness >= Real(kInfiniteSharpness) ? sharpness : std::max(sharpness - Real(steps), Real(0));
    }
    bool is_sharp(const Spoke& s, int steps) const { return s.is_open() || sharpness_after(s.sharpness, steps) > 0; }
    Vec3l moved(Rule rule, int steps, const std::vector<Vec3l>& middles) const;
    Vec3l moved(const std::vector<Vec3l>& middles) const;
    void subdivide();

    Vec3l p_;
    Real corner_ = 0;
    bool is_held_ = false;
    std::vector<Spoke> spokes_;
    std::vector<Face> faces_;
};

std::size_t FanStar::spoke_to(const Cage& cage, std::uint32_t vertex)
{
    for (std::size_t s = 0; s < spokes_.size(); ++s)
        if (spokes_[s].vertex == vertex) return s;
    spokes_.push_back({vertex, Vec3l(cage.positions[vertex]), 0, {}, {}});
    return spokes_.size() - 1;
}

FanStar::FanStar(const Cage& cage, std::uint32_t vertex) : p_(cage.positions[vertex])
{
    std::size_t at = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        const std::uint32_t* face = &cage.face_vertices[at];
        at += size;
        for (std::uint32_t c = 0; c < size; ++c) {
            if (face[c] != vertex) continue;
            Face made;
            made.from = spoke_to(cage, face[(c + 1) % size]);
            made.to = spoke_to(cage, face[(c + size - 1) % size]);
            made.size = Real(size);
            for (std::uint32_t k = 2; k + 1 < size; ++k) made.others += Vec3l(cage.positions[face[(c + k) % size]]);
            spokes_[made.from].begins.push_back(faces_.size());
            spokes_[made.to].ends.push_back(faces_.size());
            faces_.push_back(made);
        }
    }
    for (const Corner& c : cage.corners)
        if (c.vertex == vertex) corner_ = Real(c.sharpness);
    for (const Crease& c : cage.creases)
        for (Spoke& s : spokes_)
            if (std::minmax(c.v0, c.v1) == std::minmax(vertex, s.vertex)) s.sharpness = Real(c.sharpness);
    is_held_ = is_held();
}

bool FanStar::softens_alike() const
{
    Real largest = corner_ < Real(kInfiniteSharpness) ? corner_ : 0;
    const auto is_soft = [](const Spoke& s) { return !s.is_open() && s.sharpness < Real(kInfiniteSharpness); };
    for (const Spoke& s : spokes_)
        if (is_soft(s)) largest = std::max(largest, s.sharpness);
    const auto differs = [&](Real s) { return s != largest && std::ceil(s) == std::ceil(largest); };
    return !differs(corner_) &&
           std::ranges::none_of(spokes_, [&](const Spoke& s) { return is_soft(s) && differs(s.sharpness); });
}

bool FanStar::is_held() const
{
    std::vector<std::size_t> open;
    for (std::size_t s = 0; s < spokes_.size(); ++s)
        if (spokes_[s].is_open()) open.push_back(s);
    // A corner of one face is sharp by the rule for borders.
    if (faces_.size() < 2 || open.size() > 2 || open.size() == 1) return true;
    std::size_t found = 0;
    if (open.empty()) {
        std::size_t f = 0;
        do {
            f = spokes_[faces_[f].to].begins[0];
            ++found;
        } while (f != 0);
        return found != faces_.size();
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        if (!spokes_[faces_[f].from].is_open()) continue;
        std::size_t last = f;
        for (++found; !spokes_[faces_[last].to].is_open(); ++found) last = spokes_[faces_[last].to].begins[0];
        if (faces_[last].to == faces_[f].from) return true;
    }
    if (found != faces_.size()) return true;
    const auto count = [&](std::size_t s) { return spokes_[s].begins.size() + spokes_[s].ends.size(); };
    if (count(open[0]) == 1 && count(open[1]) == 1) return false;
    return count(open[0]) < 3 || count(open[1]) < 3 || !softens_alike();
}

FanStar::Rule FanStar::rule(int steps) const
{
    const auto sharp = std::ranges::count_if(spokes_, [&](const Spoke& s) { return is_sharp(s, steps); });
    if (is_held_ || sharpness_after(corner_, steps) > 0 || sharp > 2) return Rule::Corner;
    return sharp == 2 ? Rule::Crease : Rule::Smooth;
}

Vec3l FanStar::moved(Rule rule, int steps, const std::vector<Vec3l>& middles) const
{
    if (rule == Rule::Corner) return p_;
    Vec3l sum(0);
    if (rule == Rule::Crease) {
        for (const Spoke& s : spokes_)
            if (is_sharp(s, steps)) sum += s.end;
        return (sum + p_ * Real(6)) / Real(8);
    }
    for (const Spoke& s : spokes_) sum += s.end;
    for (const Vec3l m : middles) sum += m;
    const auto n = static_cast<Real>(spokes_.size());
    return p_ * ((n - 2) / n) + sum / (n * n);
}

Vec3l FanStar::moved(const std::vector<Vec3l>& middles) const
{
    const Vec3l old_rule = moved(rule(0), 0, middles);
    if (rule(0) == rule(1)) return old_rule;
    Real sum = 0, count = 0;
    const auto add = [&](Real s) {
        if (s > 0 && sharpness_after(s, 1) <= 0) sum += s, ++count;
    };
    add(corner_);
    for (const Spoke& s : spokes_)
        if (!s.is_open()) add(s.sharpness);
    const Vec3l new_rule = moved(rule(1), 1, middles);
    return new_rule + (old_rule - new_rule) * (count > 0 ? std::min(sum / count, Real(1)) : Real(0));
}

void FanStar::subdivide()
{
    std::vector<Vec3l> middles;
    for (const Face& f : faces_) middles.push_back((p_ + spokes_[f.from].end + spokes_[f.to].end + f.others) / f.size);
    const Vec3l next = moved(middles);
    for (Spoke& s : spokes_) {
        const Vec3l middle = (p_ + s.end) / Real(2);
        const Real sharp = s.is_open() ? 1 : std::min(s.sharpness, Real(1));
        const Vec3l smooth = s.is_open() ? middle : (middle * Real(2) + middles[s.begins[0]] + middles[s.ends[0]]) / Real(4);
        s.end = smooth + (middle - smooth) * sharp;
        s.sharpness = sharpness_after(s.sharpness, 1);
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        faces_[f].others = middles[f];
        faces_[f].size = 4;
    }
    corner_ = sharpness_after(corner_, 1);
    p_ = next;
}

Vec3l FanStar::limit()
{
    for (int step = 0; step < 80; ++step) subdivide();
    return p_;
}

/// Makes cages whose vertex 0 lies on the edges to 1 and 2, with several fans of faces around it.
class FanMaker {
public:
    explicit FanMaker(std::uint64_t seed) : random_(seed, 0, 910) { add_vertices(3); }

    /// Adds a fan of faces from one vertex to another, or to itself, or around vertex 0 (from == to == kRing).
    static constexpr std::uint32_t kRing = ~0u;
    void add(std::uint32_t from, std::uint32_t to, std::size_t count)
    {
        if (from == kRing) from = to = add_vertices(1);
        const bool is_turned = random_.number() < 0.3;
        for (std::size_t k = 0; k < count; ++k) {
            const std::uint32_t next = k + 1 < count ? add_vertices(1) : to;
            std::vector<std::uint32_t> face{0, from};
            for (std::size_t more = random_.index(3); more > 0; --more) face.push_back(add_vertices(1));
            face.push_back(next);
            if (is_turned) std::reverse(face.begin(), face.end());
            faces_.push_back(face);
            if (k + 1 < count) spokes_.push_back(next);
            from = next;
        }
    }
    /// Makes a crease of each spoke that is not at the end of a fan, with the given chance.
    void add_creases(double chance, float sharpness)
    {
        for (const std::uint32_t v : spokes_) {
            const float of = sharpness > 0 ? sharpness : 0.25f * float(1 + random_.index(12));
            if (random_.number() < chance) cage_.creases.push_back({0, v, of});
        }
    }
    Cage make()
    {
        for (std::size_t k = faces_.size(); k > 1; --k) std::swap(faces_[k - 1], faces_[random_.index(k)]);
        for (const std::vector<std::uint32_t>& face : faces_) {
            cage_.face_sizes.push_back(static_cast<std::uint32_t>(face.size()));
            cage_.face_vertices.insert(cage_.face_vertices.end(), face.begin(), face.end());
        }
        return cage_;
    }
    CaseRandom& random() { return random_; }

private:
    std::uint32_t add_vertices(int count)
    {
        const auto first = static_cast<std::uint32_t>(cage_.positions.size());
        for (; count > 0; --count) cage_.positions.push_back(Vec3f(random_.inside_cube()));
        return first;
    }

    CaseRandom random_;
    Cage cage_;
    std::vector<std::vector<std::uint32_t>> faces_;
    std::vector<std::uint32_t> spokes_;
};

/// Returns the patch and the place in it of a face's corner, or of what lies so far inside of it.
lod::PatchPoint at_corner(std::uint32_t face, std::uint32_t size, std::uint32_t corner, float inside)
{
    if (size != 4) return {{face, corner}, inside, inside};
    const bool is_right = corner == 1 || corner == 2, is_top = corner >= 2;
    return {{face, 0}, is_right ? 1 - inside : inside, is_top ? 1 - inside : inside};
}

/// Compares the surface of each face at its corners with the limits of the cage's vertices, and that close to the corners.
void expect_one_limit(Cage cage, const std::string& what)
{
    sanitize(cage);  // some creases at vertices of two faces are dropped
    const DicedCage diced(cage, 0);
    const double extent = 2 * cage.bounds().radius();
    std::vector<Vec3d> limits;
    for (std::uint32_t v = 0; v < cage.positions.size(); ++v) limits.push_back(Vec3d(FanStar(cage, v).limit()));
    lod::PosedPatch patch;
    double at = 0, beside = 0;
    std::uint32_t first = 0;
    for (std::uint32_t f = 0; f < cage.face_sizes.size(); first += cage.face_sizes[f++])
        for (std::uint32_t c = 0; c < cage.face_sizes[f]; ++c) {
            const auto distance = [&](float inside) {
                const lod::PatchPoint place = at_corner(f, cage.face_sizes[f], c, inside);
                patch.set(diced.posed, place.patch);
                const Vec3d p = Vec3d(patch.point(place.u, place.v)) + diced.posed.anchor;
                return glm::distance(p, limits[cage.face_vertices[first + c]]) / extent;
            };
            at = std::max(at, distance(0));
            beside = std::max(beside, distance(0x1p-12f));
        }
    EXPECT_LE(at, 1e-6) << what;
    EXPECT_LE(beside, 0.01) << what << ", beside a corner";
}

TEST(FanLimits, AreThoseOfSubdivisionForEachFace)
{
    for (std::uint64_t seed = 1; seed <= (is_long() ? 2000u : 60u) && !testing::Test::HasFailure(); ++seed) {
        FanMaker maker(seed);
        const std::size_t across = maker.random().index(5), closed = maker.random().index(3);
        for (std::size_t k = 0; k < across; ++k) maker.add(1, 2, 1 + maker.random().index(3));
        for (std::size_t k = 0; k < closed; ++k) {
            const auto end = static_cast<std::uint32_t>(1 + maker.random().index(2));
            maker.add(end, end, 3 + maker.random().index(2));
        }
        if (across + closed == 0 || maker.random().number() < 0.3)
            maker.add(FanMaker::kRing, FanMaker::kRing, 3 + maker.random().index(3));
        if (maker.random().number() < 0.5) maker.add_creases(0.4, maker.random().number() < 0.5 ? 1.75f : 0);
        expect_one_limit(maker.make(), "seed " + std::to_string(seed));
    }
}

// A book of so many pages has a vertex of more than 64 faces between them.
TEST(FanLimits, AreThoseOfSubdivisionInTheMiddleOfABook)
{
    for (const std::size_t pages : {33u, 40u, 70u})
        for (const float sharpness : {0.0f, 2.5f}) {
            FanMaker maker(pages);
            for (std::size_t page = 0; page < pages; ++page) maker.add(1, 2, 1 + page % 3);
            if (sharpness > 0) maker.add_creases(0.2, sharpness);
            expect_one_limit(maker.make(), std::to_string(pages) + " pages, sharpness " + std::to_string(sharpness));
        }
}

/// Returns three pages of 4 x 3 quads that share a spine, with any texture coordinates.
Cage book_of_three_pages()
{
    CaseRandom random(1, 0, 911);
    Cage cage;
    UvSet set;
    const auto at = [](std::uint32_t page, std::uint32_t x, std::uint32_t y) {
        return x == 0 ? y : 5 + 15 * page + 5 * (x - 1) + y;
    };
    for (std::uint32_t page = 0; page < 3; ++page)
        for (std::uint32_t y = 0; y < 4; ++y)
            for (std::uint32_t x = 0; x < 3; ++x) {
                cage.face_sizes.push_back(4);
                cage.face_vertices.insert(cage.face_vertices.end(),
                                          {at(page, x, y), at(page, x + 1, y), at(page, x + 1, y + 1), at(page, x, y + 1)});
            }
    for (int v = 0; v < 50; ++v) {
        cage.positions.push_back(Vec3f(random.inside_cube()));
        set.values.push_back(Vec2f(random.inside_cube()));
    }
    cage.uv_sets = {set};
    return cage;
}

// The texture coordinate of a vertex of several fans stays where it is, and those beside it are close to it.
TEST(FanLimits, OfTextureCoordinatesAreContinuous)
{
    const Cage cage = book_of_three_pages();
    const DicedCage diced(cage, 0);
    lod::PosedPatch patch;
    int compared = 0;
    for (std::uint32_t f = 0; f < cage.face_sizes.size(); ++f)
        for (std::uint32_t c = 0; c < 4; ++c)
            for (const float inside : {0.0f, 0x1p-12f, 0x1p-8f}) {
                const std::uint32_t v = cage.face_vertices[4 * f + c];
                if (v == 0 || v > 3) continue;  // the spine without its ends
                const lod::PatchPoint place = at_corner(f, 4, c, inside);
                patch.set_uv(diced.posed, place.patch, 0);
                const Vec2f uv(patch.point(place.u, place.v));
                EXPECT_LE(glm::distance(uv, cage.uv_sets[0].values[v]), 16 * inside + 1e-6f) << "face " << f;
                ++compared;
            }
    EXPECT_EQ(compared, 3 * 6 * 3);
}

}  // namespace
}  // namespace occam::test
