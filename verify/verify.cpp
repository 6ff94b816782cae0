#include "verify/verify.h"

#include <bit>
#include <optional>
#include <string>

#include "accel/placement.h"
#include "base/error.h"
#include "base/error_without_file.h"
#include "scenegraph/foreign_texture.h"
#include "verify/closed.h"
#include "verify/escape_test.h"
#include "verify/ray_line.h"

namespace occam {
namespace {

/// Begins the report of a cage, and says why it cannot be tested if that is so.
VerifiedCage report_of(const ShownCage& shown)
{
    const Cage& cage = shown.slot.cage;
    VerifiedCage report;
    if (shown.node) report.node = shown.node->name;
    report.cage = cage.name;
    report.faces = cage.face_count();
    report.not_testable = cage.scheme == Scheme::Triangles ? "it is a triangle mesh, the same at every level"
                                                           : why_not_closed(cage);
    return report;
}

/// Calls call(shown, textures) for each placed cage of a scene. Throws Error if a displacement cannot be read.
template <class Call>
void for_each_shown(Scene& scene, Call&& call)
{
    scene.refit();
    TextureStore textures(std::size_t(1) << 30);
    if (scene.contents().has(Contents::Displaced)) textures.prepare(scene);
    accel::for_each_placement(scene, 0, [&](const Node& node, std::span<const Mat4d> world_from_node) {
        for (const CageId id : node.cages) {
            const CageSlot* slot = scene.find(id);
            if (!slot) continue;  // it was removed
            const std::optional<CageSlot> made = slot->is_on_demand() ? std::optional(slot->made()) : std::nullopt;
            call(ShownCage{made ? *made : *slot, &node, scene.find(node.skin), world_from_node, scene.shutter_segments()},
                 textures);
            textures.throw_if_failed();
        }
    });
}

/// Calls visit(test, size, sizes) for the cage at each size that it has while the shutter is open, until it returns false.
template <class Visit>
void for_each_size(const ShownCage& shown, const VerifySettings& settings, const TextureStore* textures,
                   VerifiedCage& report, std::size_t number, Visit&& visit)
{
    for (std::size_t size = 0, sizes = 1; size < sizes; ++size) {
        EscapeTest test(shown, settings, textures, report, number, size);
        sizes = std::max<std::size_t>(1, test.size_count());
        if (!visit(test, size, sizes)) return;
    }
}

/// Tests the cage with the same part of the rays at each size. An error ends the test of this cage alone.
void test_each_size(const ShownCage& shown, const VerifySettings& settings, const TextureStore* textures,
                    VerifiedCage& report, std::size_t number = 0)
{
    try {
        for_each_size(shown, settings, textures, report, number, [&](EscapeTest& test, std::size_t size, std::size_t sizes) {
            test.run(settings.rays * (size + 1) / sizes);
            return true;
        });
    } catch (const Error& e) {
        report.has_failed = true;
        report.not_testable = report.rays == 0
                                  ? e.what()
                                  : "its test ended after " + std::to_string(report.rays) + " rays: " + e.what();
    }
}

}  // namespace

void check(const VerifySettings& settings)
{
    if (settings.rays > kMostVerifyRays)
        throw error_without_file("there can be at most " + std::to_string(kMostVerifyRays) + " rays for each cage, not " +
                                     std::to_string(settings.rays),
                                 "rays");
    const int rate = settings.largest_rate;
    if (rate < 1 || rate > kLargestVerifyRate || !std::has_single_bit(static_cast<unsigned>(rate)))
        throw error_without_file(
            "it must be a power of two from 1 to " + std::to_string(kLargestVerifyRate) + ", not " + std::to_string(rate),
            "largest_rate");
    if (!(settings.overlap_ulps >= 0 && settings.overlap_ulps <= kWidestVerifyOverlap))
        throw error_without_file("it must be from 0 to " + std::to_string(static_cast<int>(kWidestVerifyOverlap)) +
                                     " ulps, not " + std::to_string(settings.overlap_ulps),
                                 "overlap_ulps");
}

VerifiedCage verify(const Cage& cage, const Mat4d& world_from_object, const VerifySettings& settings,
                    const TextureStore* textures)
{
    check(settings);
    Scene scene;  // which drops what is no face
    const CageSlot& slot = scene.cage(add_with_foreign_texture(scene, without_materials(cage)));
    const ShownCage shown{slot, nullptr, nullptr, {&world_from_object, 1}, 0};
    VerifiedCage report = report_of(shown);
    if (report.not_testable.empty()) test_each_size(shown, settings, textures, report);
    if (textures) textures->throw_if_failed();
    return report;
}

std::vector<VerifiedCage> verify(Scene& scene, const VerifySettings& settings)
{
    check(settings);
    std::vector<VerifiedCage> reports;
    for_each_shown(scene, [&](const ShownCage& shown, const TextureStore& textures) {
        const std::size_t number = reports.size();
        VerifiedCage& report = reports.emplace_back(report_of(shown));
        if (report.not_testable.empty()) test_each_size(shown, settings, &textures, report, number);
    });
    return reports;
}

bool replay(Scene& scene, const VerifySettings& settings, std::string_view text, std::ostream& out)
{
    check(settings);
    const RayLine line = read_ray_line(text);
    std::size_t number = 0;
    bool holds = true;
    for_each_shown(scene, [&](const ShownCage& shown, const TextureStore& textures) {
        if (number++ != line.cage) return;
        VerifiedCage report = report_of(shown);
        if (!report.not_testable.empty())
            throw error_without_file("the cage cannot be tested: " + report.not_testable, "ray");
        // A ray of a time at which the cage is left out sees its last size.
        for_each_size(shown, settings, &textures, report, line.cage,
                      [&](EscapeTest& test, std::size_t size, std::size_t sizes) {
                          if (!test.is_seen_at(line.time) && size + 1 < sizes) return true;
                          test.replay(line, out);
                          return false;
                      });
        holds = report.holds();
    });
    if (line.cage >= number)
        throw error_without_file(
            "there is no cage " + std::to_string(line.cage) + "; the scene has " + std::to_string(number), "ray");
    return holds;
}

}  // namespace occam
