// The suite compares a scene of 10,000 lights with the same scene that has only the ten of them that matter: the error of
// each against many samples of itself, at equal time, in turns. The lights are placed lights, or emissive triangles.
#include <cmath>
#include <vector>

#include "api/include/occam/occam.h"
#include "render/compare.h"
#include "render/setting_rows.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 15, kMatter = 10, kReferenceSamples = 1024, kSamples = 8;

void add_square(Cage& to, Vec3f at, float half)
{
    const auto first = static_cast<std::uint32_t>(to.positions.size());
    for (const Vec3f corner : {Vec3f(-half, 0, -half), Vec3f(half, 0, -half), Vec3f(half, 0, half), Vec3f(-half, 0, half)})
        to.positions.push_back(at + corner);
    for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) to.face_vertices.push_back(first + corner);
}

// A floor with tori under ten lamps. The other lamps hang over the same floor, beyond z = -61, where the camera's view of it
// ends.
// are_triangles   two of them make a lamp; otherwise lamps are squares and points
Scene lit_field(int lights, bool are_triangles)
{
    Scene scene;
    const auto add = [&](Vec3d at, NodeDesc desc) {
        desc.place.translation = at;
        scene.add_node(scene.root(), std::move(desc));
    };
    Cage floor;
    floor.scheme = Scheme::Triangles;
    floor.positions = {{-900, -0.5f, 900}, {900, -0.5f, 900}, {900, -0.5f, -900}, {-900, -0.5f, -900}};
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    add(Vec3d(0), {.cages = {scene.add(std::move(floor))}});
    const CageId shape = scene.add(torus(16, 8));
    for (int i = 0; i < 9; ++i) add({4.0 * (i % 3 - 1), 0, 4.0 * (i / 3 - 1)}, {.cages = {shape}});
    Cage lamps;
    lamps.scheme = Scheme::Triangles;
    for (int i = 0; i < lights; ++i) {
        const int n = i - kMatter;
        const Vec3d at = i < kMatter ? Vec3d(3.0 * (i % 5 - 2), 2.5 + 0.2 * i, 3.0 * (i / 5) - 1.5)
                                     : Vec3d(8.0 * (n % 100 - 50) + 4, 3, -100 - 8.0 * (n / 100));
        if (are_triangles) {
            if (i % 2 == 0) add_square(lamps, Vec3f(at), 0.15f);
            continue;
        }
        AreaLight square;
        square.size = Vec2f(0.3f);
        square.radiance = Vec3f(20);
        NodeDesc desc;
        if (i % 2) desc.light = scene.add(Light{"", PointLight{Vec3f(3)}});
        else desc.light = scene.add(Light{"", square});
        desc.place.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // shines down
        add(at, std::move(desc));
    }
    if (!are_triangles) return scene;
    Material shining;
    shining.emission = Vec3f(20);
    lamps.materials = {scene.add(shining)};
    add(Vec3d(0), {.cages = {scene.add(std::move(lamps))}});
    return scene;
}

// Renders one scene again and again with other seeds, and compares its pictures with one of many samples.
class Measuring {
public:
    Measuring(Scene& scene, IntegratorKind kind) : scene_(scene)
    {
        settings_.integrator = kind;
        settings_.bounces = 2;
        settings_.sky = shade::Sky::Off;  // emissive surfaces alone light the field of triangles
        reference_ = renderer_.render(scene_, camera_, settings_);
        settings_.spp = kSamples;
    }
    void run(int number)
    {
        settings_.seed = static_cast<std::uint64_t>(number) + 7;
        const double start = process_seconds();
        const Image picture = renderer_.render(scene_, camera_, settings_);
        seconds.push_back(process_seconds() - start);
        rel_mse += render::compare(picture, reference_, "beauty").rel_mse / kRuns;
    }

    std::vector<double> seconds;
    double rel_mse = 0;

private:
    Scene& scene_;
    Renderer renderer_{Resources{.threads = 1}};
    Camera camera_ = Camera::look_at({0, 5, 11}, {0, 0, 0}, {0, 1, 0}, 0.7f);
    Settings settings_{.width = 64, .height = 36, .spp = kReferenceSamples};
    Image reference_;
};

}  // namespace

void run_lights(Report& report)
{
    for (const bool are_triangles : {false, true}) {
        const std::string what = are_triangles ? "10,000 emissive triangles" : "10,000 lights";
        if (!report.wants(what)) continue;
        Scene few = lit_field(kMatter, are_triangles), many = lit_field(10'000, are_triangles);
        for (const IntegratorKind kind : {IntegratorKind::Direct, IntegratorKind::Path}) {
            Measuring ten(few, kind), all(many, kind);
            for (int run = 0; run < kRuns; ++run) {
                ten.run(run);
                all.run(run);
            }
            std::vector<double> at_equal_time;  // one for each pair of runs, of which each has the clock of its minute
            for (std::size_t i = 0; i < ten.seconds.size(); ++i)
                at_equal_time.push_back(std::sqrt(all.rel_mse / ten.rel_mse * all.seconds[i] / ten.seconds[i]));
            Row row{"lights", what + " beside ten, " + std::string(render::name_of(kind))};
            row.add("cpu_s", all.seconds).add("rel_mse", all.rel_mse).add("ten_cpu_s", ten.seconds);
            row.add("ten_rel_mse", ten.rel_mse).add("error_at_equal_time", at_equal_time);
            report.add(std::move(row));
        }
    }
}

}  // namespace occam::bench
