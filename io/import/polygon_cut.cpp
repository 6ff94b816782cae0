// Triangulation of polygons: convex ones become a fan or are halved, others are cut by ear clipping (Meisters 1975).
#include "io/import/polygons.h"

#include <algorithm>

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
    const std::size_t size = p.size();
    for (std::size_t i = 0; i < size; ++i)
        if (turn(n, p[i], p[(i + 1) % size], p[(i + 2) % size]) < 0) return false;
    return true;
}

// Holds the corners that are left, in order, and which of them can be cut off.
class Ring {
public:
    Ring(Vec3d normal, std::span<const Vec3f> corners) : normal_(normal), p_(corners)
    {
        for (std::uint32_t i = 0; i < corners.size(); ++i) ring_.push_back(i);
        judge_all();
    }
    std::size_t size() const { return ring_.size(); }
    const std::vector<std::uint32_t>& corners() const { return ring_; }

    // Finds the first ear. Cutting one off changes only its two neighbours, unless the polygon touches itself: then all
    // corners are judged again, a few times. A polygon that crosses itself may have no ear; then the first corner is taken.
    std::size_t find_ear()
    {
        for (;;) {
            const auto found = std::find(is_ear_.begin(), is_ear_.end(), char(1));
            if (found != is_ear_.end()) return static_cast<std::size_t>(found - is_ear_.begin());
            if (retries_ == 0) return 0;
            --retries_;
            judge_all();
            if (std::find(is_ear_.begin(), is_ear_.end(), char(1)) == is_ear_.end()) return 0;
        }
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
    void judge_all()
    {
        is_ear_.resize(ring_.size());
        for (std::size_t i = 0; i < ring_.size(); ++i) is_ear_[i] = judge(i);
    }
    bool judge(std::size_t i) const
    {
        const std::uint32_t a = ring_[before(i)], b = ring_[i], c = ring_[after(i)];
        if (turn(normal_, p_[a], p_[b], p_[c]) <= 0) return false;
        return std::none_of(ring_.begin(), ring_.end(), [&](std::uint32_t q) {
            return q != a && q != b && q != c && turn(normal_, p_[a], p_[b], p_[q]) >= 0 &&
                   turn(normal_, p_[b], p_[c], p_[q]) >= 0 && turn(normal_, p_[c], p_[a], p_[q]) >= 0;
        });
    }

    Vec3d normal_;
    std::span<const Vec3f> p_;
    std::vector<std::uint32_t> ring_;
    std::vector<char> is_ear_;
    int retries_ = 8;
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

bool cut_polygon(std::span<const Vec3f> corners, std::vector<std::uint32_t>& out)
{
    const std::uint32_t size = static_cast<std::uint32_t>(corners.size());
    const Vec3d n = newell_normal(corners);
    const bool needs_ears = size > 3 && !is_convex(n, corners);
    if (needs_ears && size <= kMaxEarCorners) {
        Ring ring(n, corners);
        while (ring.size() > 3) ring.cut(ring.find_ear(), out);
        out.insert(out.end(), ring.corners().begin(), ring.corners().end());
        return true;
    }
    if (size > kMaxFanCorners) halve(size, out);
    else
        for (std::uint32_t i = 1; i + 1 < size; ++i) out.insert(out.end(), {0u, i, i + 1});
    return !needs_ears;
}

}  // namespace occam::import
