#include "verify/verify.h"

#include <optional>

#include "accel/placement.h"
#include "base/error_without_file.h"
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

/// Calls call(shown, textures) for each placed cage of a scene.
template <class Call>
void for_each_shown(Scene& scene, Call&& call)
{
    scene.refit();
    TextureStore textures(std::size_t(1) << 30);
    if (scene.contents().has(Contents::Displaced)) textures.prepare(scene);
    accel::for_each_placement(scene, [&](const Node& node, std::span<const Mat4d> world_from_node) {
        for (const CageId id : node.cages) {
            const CageSlot* slot = scene.find(id);
            if (!slot) continue;  // it was removed
            const std::optional<CageSlot> made = slot->is_on_demand() ? std::optional(slot->made()) : std::nullopt;
            call(ShownCage{made ? *made : *slot, &node, scene.find(node.skin), world_from_node, scene.shutter_segments()},
                 textures);
        }
    });
}

/// Tests the cage at each size that it has while the shutter is open, with the same part of the rays at each.
void test(const ShownCage& shown, const VerifySettings& settings, const TextureStore* textures, VerifiedCage& report,
          std::size_t number = 0)
{
    std::size_t sizes = 1;
    for (std::size_t size = 0; size < sizes; ++size) {
        EscapeTest test(shown, settings, textures, report, number, size);
        sizes = std::max<std::size_t>(1, test.size_count());
        test.run(settings.rays * (size + 1) / sizes);
    }
}

}  // namespace

VerifiedCage verify(const Cage& cage, const Mat4d& world_from_object, const VerifySettings& settings,
                    const TextureStore* textures)
{
    Scene scene;  // which drops what is no face
    const CageSlot& slot = scene.cage(scene.add(without_materials(cage)));
    const ShownCage shown{slot, nullptr, nullptr, {&world_from_object, 1}, 0};
    VerifiedCage report = report_of(shown);
    if (report.not_testable.empty()) test(shown, settings, textures, report);
    return report;
}

std::vector<VerifiedCage> verify(Scene& scene, const VerifySettings& settings)
{
    std::vector<VerifiedCage> reports;
    for_each_shown(scene, [&](const ShownCage& shown, const TextureStore& textures) {
        const std::size_t number = reports.size();
        VerifiedCage& report = reports.emplace_back(report_of(shown));
        if (report.not_testable.empty()) test(shown, settings, &textures, report, number);
    });
    return reports;
}

bool replay(Scene& scene, const VerifySettings& settings, std::string_view text, std::ostream& out)
{
    const RayLine line = read_ray_line(text);
    std::size_t number = 0;
    bool holds = true;
    for_each_shown(scene, [&](const ShownCage& shown, const TextureStore& textures) {
        if (number++ != line.cage) return;
        VerifiedCage report = report_of(shown);
        if (!report.not_testable.empty())
            throw error_without_file("the cage cannot be tested: " + report.not_testable, "ray");
        std::size_t sizes = 1, size = 0;
        for (; size < sizes; ++size) {
            EscapeTest test(shown, settings, &textures, report, line.cage, size);
            sizes = test.size_count();
            if (!test.is_seen_at(line.time) && size + 1 < sizes) continue;
            test.replay(line, out);
            break;
        }
        holds = report.holds();
    });
    if (line.cage >= number)
        throw error_without_file(
            "there is no cage " + std::to_string(line.cage) + "; the scene has " + std::to_string(number), "ray");
    return holds;
}

}  // namespace occam
