// Triangulation of polygons: convex ones become a fan or are halved, others are cut by ear clipping (Meisters 1975).
#include "io/import/polygons.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace occam::import {

namespace {

// Ear clipping costs the square of the number of corners, so larger polygons are cut as if they were convex.
constexpr std::size_t kMaxEarCorners = 512;
constexpr std::size_t kMaxFanCorners = 64;

Vec3d newell_normal(std::span<const Vec3f> p)
{
    Vec3d n(0);
    for (std::size_t i = 0; i < p.size(); ++i)
        n += glm::cross(Vec3d(p[i]) - Vec3d(p[0]), Vec3d(p[(i + 1) % p.size()]) - Vec3d(p[0]));
    return n;
}

// Returns twice the area of the triangle seen along n; it is positive if the triangle is counter-clockwise.
double turn(Vec3d n, Vec3f a, Vec3f b, Vec3f c) { return glm::dot(n, glm::cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a))); }

bool is_convex(Vec3d n, std::span<const Vec3f> p)
{
    // Edges without a length have no direction: those on either side of them turn against each other.
    const std::size_t size = p.size();
    std::size_t before = size - 1;
    while (before > 0 && p[before] == p[0]) --before;
    for (std::size_t i = 0; i < size; ++i) {
        const Vec3f a = p[before], b = p[i], c = p[(i + 1) % size];
        if (b == c) continue;
        const double turned = turn(n, a, b, c);
        if (turned < 0 || (turned == 0 && glm::dot(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(b)) < 0)) return false;
        before = i;
    }
    return true;
}

// Holds the corners that are left, in order, and which of them can be cut off. A polygon may touch itself: a face with a
// hole is written as one polygon that goes to the hole and back along the same edge, so that it has corners in one place.
class Ring {
public:
    Ring(Vec3d normal, std::span<const Vec3f> corners) : normal_(normal), p_(corners)
    {
        for (std::uint32_t i = 0; i < corners.size(); ++i) ring_.push_back(i);
        judge_all();
    }
    std::size_t size() const { return ring_.size(); }
    const std::vector<std::uint32_t>& corners() const { return ring_; }
    /// Returns whether a corner was taken that is no ear, or the three corners that are left run the wrong way round.
    bool crosses_itself() const { return has_forced_ || turn_at(1) < 0; }
    /// Returns how often a corner was looked at so far.
    std::uint64_t looks() const { return looks_; }

    // Finds what to cut off next: a corner where the polygon goes back to where it came from, the first ear, or where there
    // is none a corner whose triangle has no area. Cutting one off changes its two neighbours, and what a corner that is
    // gone has stood in the way of: so all corners are judged again if no ear is known, as often as does not take long. A
    // polygon that crosses itself may have no ear.
    std::size_t find_ear()
    {
        if (const auto fold = first([&](std::size_t i) { return has_equal_places(i); })) return *fold;
        if (const auto ear = known_ear()) return *ear;
        while (retries_ > 0) {
            --retries_;
            judge_all();
            if (const auto ear = known_ear()) return *ear;
            if (may_touch_) break;
            may_touch_ = true;
        }
        const auto is_straight = [&](std::size_t i) { return turn_at(i) == 0; };
        if (const auto straight = first(is_straight)) return *straight;
        has_forced_ = true;
        return first([&](std::size_t i) { return turn_at(i) > 0; }).value_or(0);
    }
    void cut(std::size_t ear, std::vector<std::uint32_t>& out)
    {
        out.insert(out.end(), {ring_[before(ear)], ring_[ear], ring_[after(ear)]});
        ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(ear));
        is_ear_.erase(is_ear_.begin() + static_cast<std::ptrdiff_t>(ear));
        const std::size_t next = ear % ring_.size(), previous = before(next);
        is_ear_[next] = judge(next);
        is_ear_[previous] = judge(previous);
    }

private:
    std::size_t before(std::size_t i) const { return (i + ring_.size() - 1) % ring_.size(); }
    std::size_t after(std::size_t i) const { return (i + 1) % ring_.size(); }
    Vec3f place(std::size_t i) const { return p_[ring_[i]]; }
    double turn_at(std::size_t i) const { return turn(normal_, place(before(i)), place(i), place(after(i))); }
    bool has_equal_places(std::size_t i) const
    {
        const Vec3f a = place(before(i)), b = place(i), c = place(after(i));
        return a == b || b == c || a == c;
    }
    template <class Is>
    std::optional<std::size_t> first(Is&& is) const
    {
        for (std::size_t i = 0; i < ring_.size(); ++i)
            if (is(i)) {
                looks_ += i + 1;
                return i;
            }
        looks_ += ring_.size();
        return std::nullopt;
    }
    std::optional<std::size_t> known_ear() const
    {
        return first([&](std::size_t i) { return is_ear_[i] != 0; });
    }
    void judge_all()
    {
        is_ear_.resize(ring_.size());
        for (std::size_t i = 0; i < ring_.size(); ++i) is_ear_[i] = judge(i);
    }
    bool judge(std::size_t i) const
    {
        const Vec3f a = place(before(i)), b = place(i), c = place(after(i));
        if (turn(normal_, a, b, c) <= 0) return false;
        for (std::size_t j = 0; j < ring_.size(); ++j)
            if (j != before(i) && j != i && j != after(i) && blocks(j, a, b, c)) {
                looks_ += j + 1;
                return false;
            }
        looks_ += ring_.size();
        return true;
    }
    // Returns whether another corner keeps the triangle from being cut off. One in the place of `a` or of `c` does not,
    // since an edge that goes from there into the triangle ends in it, and so its end does. From `b` it could leave through
    // the opposite side. A corner elsewhere on a side does, as long as there are ears without such corners.
    bool blocks(std::size_t j, Vec3f a, Vec3f b, Vec3f c) const
    {
        const Vec3f q = place(j);
        const double ab = turn(normal_, a, b, q);
        if (!(ab >= 0)) return false;
        const double bc = turn(normal_, b, c, q);
        if (!(bc >= 0)) return false;
        const double ca = turn(normal_, c, a, q);
        if (!(ca >= 0) || q == a || q == c) return false;
        const bool is_inside = ab > 0 && bc > 0 && ca > 0;
        if (q != b && (is_inside || !may_touch_)) return true;
        return enters(place(before(j)), q, a, b, c) || enters(place(after(j)), q, a, b, c);
    }
    // Returns whether an edge from `q`, which is on the border of the triangle, to `to` goes through its inside.
    bool enters(Vec3f to, Vec3f q, Vec3f a, Vec3f b, Vec3f c) const
    {
        const auto is_beyond = [&](Vec3f from, Vec3f end) {
            const bool is_on_side = q == from || q == end || turn(normal_, from, end, q) == 0;
            return is_on_side && turn(normal_, from, end, to) <= 0;
        };
        return !is_beyond(a, b) && !is_beyond(b, c) && !is_beyond(c, a);
    }

    Vec3d normal_;
    std::span<const Vec3f> p_;
    std::vector<std::uint32_t> ring_;
    std::vector<char> is_ear_;
    int retries_ = 8;
    bool may_touch_ = false, has_forced_ = false;
    mutable std::uint64_t looks_ = 0;
};

// Halves a convex polygon of many corners again and again. The boxes of a fan's triangles would all overlap at one corner,
// and rays would have to test all of them there.
void halve(std::uint32_t corners, std::vector<std::uint32_t>& out)
{
    std::vector<std::pair<std::uint32_t, std::uint32_t>> todo{{0u, corners - 1}};
    while (!todo.empty()) {
        const auto [first, last] = todo.back();
        todo.pop_back();
        if (last - first < 2) continue;
        const std::uint32_t middle = first + (last - first) / 2;
        out.insert(out.end(), {first, middle, last});
        todo.push_back({middle, last});
        todo.push_back({first, middle});
    }
}

}  // namespace

CutPolygon cut_polygon(std::span<const Vec3f> corners, EarBudget& budget, std::vector<std::uint32_t>& out)
{
    const std::uint32_t size = static_cast<std::uint32_t>(corners.size());
    const Vec3d n = newell_normal(corners);
    const bool needs_ears = size > 3 && !is_convex(n, corners);
    const bool has_few_corners = size <= kMaxEarCorners;
    if (needs_ears && has_few_corners && !budget.is_used_up()) {
        Ring ring(n, corners);
        while (ring.size() > 3) ring.cut(ring.find_ear(), out);
        out.insert(out.end(), ring.corners().begin(), ring.corners().end());
        budget.take(ring.looks());
        return ring.crosses_itself() ? CutPolygon::Crossing : CutPolygon::Whole;
    }
    if (size > kMaxFanCorners) halve(size, out);
    else
        for (std::uint32_t i = 1; i + 1 < size; ++i) out.insert(out.end(), {0u, i, i + 1});
    if (!needs_ears) return CutPolygon::Whole;
    return has_few_corners ? CutPolygon::WithoutEars : CutPolygon::AsConvex;
}

}  // namespace occam::import
