// The suite measures what hidden nodes cost a frame: a flat list of them, behind a wall and beside the picture, in random
// order. Either nothing changes, or one thing moves while the shutter is open and is recorded anew in each frame, or the
// frame has more samples than its deadline allows.
#include <memory>

#include "api/include/occam/occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRounds = 21, kSide = 16;

enum class Kind { Still, Moving, Stopped };

// Holds a torus before a wall, and nodes that no ray meets.
class FlatCrowd {
public:
    explicit FlatCrowd(std::size_t hidden) : hidden_(hidden), renderer_({.threads = 1})
    {
        const auto add = [&](Vec3d at, CageId cage) {
            NodeDesc desc;
            desc.place.translation = at;
            desc.cages = {cage};
            return scene_.add_node(scene_.root(), std::move(desc));
        };
        const CageId shape = scene_.add(torus(8, 6));
        moving_ = add(Vec3d(0), shape);
        Cage wall;
        wall.scheme = Scheme::Triangles;
        wall.positions = {{-90, -90, -3}, {90, -90, -3}, {0, 180, -3}};
        wall.face_vertices = {0, 1, 2};
        add(Vec3d(0), scene_.add(std::move(wall)));
        for (std::size_t i = 0; i < hidden; ++i) {
            const std::size_t n = i * 7919 % hidden;  // a prime that divides no number of nodes here
            add({3.0 * double(n % 1000) + (i % 2 ? 500 : -1500), 3.0 * double(n / 1000), -10}, shape);
        }
    }
    double render(Kind kind)
    {
        const double start = process_seconds();
        Camera camera = Camera::look_at({0, 2.5, 4}, {0, 0, 0}, {0, 1, 0}, 0.7f);
        const auto rise = [&](double tau) {
            scene_.set_transform(moving_, Trs{.translation = {0, 0.3 * tau * tau, 0}}.matrix());
        };
        if (kind == Kind::Moving)
            camera = record_shutter(
                scene_, rise, [&] { return camera; }, kSide);
        Settings settings{.width = kSide, .height = kSide, .spp = 1};
        if (kind == Kind::Stopped) settings.spp = 1024, settings.deadline_s = 5e-3;
        renderer_.render(scene_, camera, settings);
        return process_seconds() - start;
    }
    std::size_t hidden() const { return hidden_; }
    const FrameStats& stats() const { return renderer_.stats(); }

private:
    std::size_t hidden_;
    Scene scene_;
    NodeId moving_;
    Renderer renderer_;
};

}  // namespace

void run_nodes(Report& report)
{
    std::vector<std::unique_ptr<FlatCrowd>> crowds;
    std::vector<double> first;
    for (const std::size_t hidden : {std::size_t(10), std::size_t(200'000), std::size_t(1'000'000)}) {
        crowds.push_back(std::make_unique<FlatCrowd>(hidden));
        first.push_back(crowds.back()->render(Kind::Still));
    }
    for (const Kind kind : {Kind::Still, Kind::Moving, Kind::Stopped}) {
        std::vector<std::vector<double>> seconds(crowds.size());
        for (int round = 0; round < kRounds; ++round)
            for (std::size_t c = 0; c < crowds.size(); ++c) seconds[c].push_back(crowds[c]->render(kind));
        for (std::size_t c = 0; c < crowds.size(); ++c) {
            std::vector<double> more;
            for (std::size_t i = 0; i < seconds[c].size(); ++i) more.push_back(1e3 * (seconds[c][i] - seconds[0][i]));
            constexpr const char* kNames[] = {"", ", one thing moves", ", stopped after 5 ms"};
            Row row{"nodes", std::to_string(crowds[c]->hidden()) + " hidden nodes" + kNames[static_cast<int>(kind)]};
            row.add("frame_cpu_ms", times(seconds[c], 1e3)).add("more_than_ten_ms", more);
            if (kind == Kind::Still) row.add("first_frame_cpu_ms", 1e3 * first[c]);
            report.add(row.add("rebuilt_bytes", double(crowds[c]->stats().memory.arena_peak_bytes)));
        }
    }
}

}  // namespace occam::bench
