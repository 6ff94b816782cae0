// Sends rays from points inside a closed cage, and counts those that leave it through the surface.
//
// Space    all lengths are in the unit of a frame that shows the cage alone (FrameScale).
#pragma once

#include <map>
#include <memory>
#include <ostream>
#include <vector>

#include "accel/tracer.h"
#include "scenegraph/frame_scale.h"
#include "verify/grazing.h"
#include "verify/ray_line.h"
#include "verify/silhouettes.h"
#include "verify/starts.h"
#include "verify/subject.h"
#include "verify/verify.h"

namespace occam {

/// Tests one placed cage: sends rays from inside it and counts those that leave.
class EscapeTest {
public:
    /// number   of the placed cage among those that are reported
    /// size     as Subject has it
    EscapeTest(const ShownCage& shown, const VerifySettings& settings, const TextureStore* textures, VerifiedCage& report,
               std::size_t number, std::size_t size);

    std::size_t size_count() const noexcept { return subject_.size_count(); }
    /// Returns whether rays of this time see the cage at this size.
    bool is_seen_at(float time) const;

    /// Sends rays until the report counts as many. The cage cannot be tested if no size has a point inside.
    void run(std::uint64_t rays);

    /// Returns at how many moments rays were sent.
    std::size_t moments_seen() const;

    /// Traces one ray, writes what it does, and judges it.
    void replay(const RayLine& line, std::ostream& out);

private:
    /// Sets the levels of the test and those of the engine, after finest_.
    void set_levels();

    static constexpr int kLevels = 4, kFiner = 8, kInstants = 8;
    static constexpr std::size_t kRaysOfAView = 512;

    /// Chooses the moments at which rays see the cage: one if it stands still, else one of its keys, and others anywhere.
    void choose_instants();

    enum class Moments { All, WithoutInside };
    static bool is_among(const Instant& instant, Moments those) { return those == Moments::All || !instant.has_inside; }

    /// Dices the cage from this level on, at those moments, and forgets what was made for another level or moment.
    void dice(int finest, Moments those);
    /// Returns whether the test may look at the next finer level, too, at those moments.
    bool has_finer_level(Moments those) const;

    /// Finds points anywhere inside the cage, at the moments at which none was found before. Returns at how many it finds
    /// some.
    std::size_t find_starts();
    /// Finds other points instead, behind faces that were not met. Returns how many.
    std::size_t find_starts_behind();
    bool has_starts() const;

    /// Dices the cage from the first level on at which there is a point inside at some moment. The level is finer than the
    /// settings ask for if the inside is thinner than its edges. Returns false if there is none.
    bool find_first_level();

    /// Sends rays until the report counts as many, if there are starts.
    void send(std::uint64_t rays);
    /// Tests the first level, and finer ones while there are faces that were not met.
    void test_all_levels(std::uint64_t rays);
    /// Looks at finer levels for points inside at the moments that have none at the first level, since the cage may be
    /// thinner then. Sends these moments their share of the rays.
    void test_thin_moments(std::uint64_t rays);
    /// Sends rays from the level's starts, and from others behind the faces that they did not meet, until no more of these
    /// are met.
    void test_level(std::uint64_t rays);

    /// Describes what the rays of a batch have in common, so that they are coherent and are traced quickly.
    struct View {
        const Instant& instant;
        const Start& start;
        int coarsest;  ///< rays from here may have a target edge length of this level at their hit
        int level;     ///< the finer level of the pair that the rays aim at
    };
    View next_view();

    accel::Ray next_ray(const View& view);

    void judge(const accel::Ray& ray, const accel::SurfaceHit& hit);
    void judge_front_side(const accel::Ray& ray, const accel::SurfaceHit& hit);
    void count_escape(const accel::Ray& ray);

    /// Returns whether the ray was out of the surface that it sees somewhere between its start, which is inside, and its
    /// hit. Places that are within rounding of the surface do not count.
    bool was_out_before(const accel::Ray& ray, const accel::SurfaceHit& hit);

    /// Makes the table of the ray's levels within the cage, with which it was traced. Returns false if there is none.
    bool make_table(const accel::Ray& ray, lod::RayLevels<float>& table) const;

    /// Returns whether the ray passed between two levels only because they overlap less here than in the engine.
    bool is_grazing(const accel::Ray& ray);

    /// Returns the winding number, about a place along the ray or beside it, of the surface that the ray sees.
    double winding_of(const accel::Ray& ray, Vec3d from_start = Vec3d(0));

    std::size_t number_;
    const VerifySettings& settings_;
    const TextureStore* textures_;
    VerifiedCage& report_;
    std::map<std::pair<float, int>, std::vector<lod::LevelGrid>> diced_;  ///< by time and level; diced for winding numbers
    Random random_;
    FrameScale scale_;  ///< all lengths are in its unit
    std::vector<Mat4d> frame_from_object_;
    Subject subject_;
    int finest_ = 0;
    std::vector<Instant> instants_;
    std::vector<std::uint32_t> not_met_;   ///< faces that no ray met
    std::vector<bool> is_met_;             ///< by face
    std::unique_ptr<accel::Frame> frame_;  ///< of the level; made when rays are sent
    std::unique_ptr<accel::Tracer> tracer_;
    lod::LevelSettings levels_, engine_levels_;
    std::unique_ptr<GrazingRays> grazing_;                     ///< made when the first ray may have left
    int front_sides_examined_ = 0, silhouettes_examined_ = 0;  ///< by the winding number
    std::unique_ptr<Silhouettes> silhouettes_;                 ///< made when the first ray hits a front side
};

}  // namespace occam
