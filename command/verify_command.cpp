#include <iostream>
#include <nlohmann/json.hpp>

#include "arguments.h"
#include "base/printable.h"
#include "framing.h"
#include "replay_command.h"

namespace occam::command {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const VerifiedCage& c, const VerifyArguments& a)
{
    Json entry = {{"node", c.node}, {"cage", c.cage}, {"faces", c.faces}};
    if (!c.not_testable.empty()) {
        entry["not_testable"] = c.not_testable;
        if (c.rays == 0) return entry;  // else its test ended with an error
    }
    entry.update({{"starts", c.starts},
                  {"faces_not_met", c.faces_not_met},
                  {"moments_not_tested", c.moments_not_tested},
                  {"rays", c.rays},
                  {"escaped", c.escaped},
                  {"outside", c.outside},
                  {"grazing", c.grazing},
                  {"not_finite", c.not_finite},
                  {"silhouettes", c.silhouettes},
                  {"front_side", c.front_side},
                  {"worst_front", c.worst_front},
                  {"replay", c.replay}});
    for (const std::string& line : c.replay) entry["replay_commands"].push_back(replay_command(a.command, line));
    return entry;
}

void print(const VerifiedCage& tested)
{
    std::cout << tested.rays << " rays, " << tested.escaped << " escaped, " << tested.not_finite << " not finite";
    if (tested.faces_not_met > 0) std::cout << "; no ray met " << tested.faces_not_met << " of the faces";
    if (tested.moments_not_tested > 0)
        std::cout << "; at " << tested.moments_not_tested << " moments no point inside was found";
    std::cout << '\n';
}

}  // namespace

int run(const VerifyArguments& a)
{
    Scene scene = open_scene(a);
    print_notes(scene);
    Framing framing(scene, a);
    print_warnings(scene.warnings, false);
    framing.pose();
    if (a.settings.shutter != Shutter{}) framing.open_shutter(framing.camera());
    if (!a.replay.empty()) return replay(scene, a.test, a.replay, std::cout) ? 0 : 1;
    const std::vector<VerifiedCage> cages = verify(scene, a.test);
    std::uint64_t tested = 0, failed = 0, rays = 0, escaped = 0, not_finite = 0;
    Json list = Json::array();
    for (const VerifiedCage& c : cages) {
        tested += c.not_testable.empty();
        failed += c.has_failed;
        rays += c.rays;
        escaped += c.escaped;
        not_finite += c.not_finite;
        list.push_back(json_of(c, a));
    }
    if (a.json) {
        const Json all = {
            {"cages", list}, {"tested", tested}, {"rays", rays}, {"escaped", escaped}, {"not_finite", not_finite}};
        std::cout << all.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    } else {
        for (const VerifiedCage& c : cages) {
            std::cout << (c.cage.empty() ? "cage" : printable_line(c.cage)) << " (" << c.faces << " faces): ";
            if (!c.not_testable.empty()) std::cout << "not testable: " << c.not_testable << '\n';
            else print(c);
            for (const std::string& line : c.replay) std::cout << "  " << replay_command(a.command, line) << '\n';
        }
        std::cout << tested << " of " << cages.size() << " cages tested, " << rays << " rays, " << escaped << " escaped, "
                  << not_finite << " not finite\n";
    }
    if (escaped + not_finite > 0) return 1;
    if (failed > 0)
        throw Error(name_of_scene(a), "the test of " + std::to_string(failed) + " of its cages ended with an error");
    if (tested == 0)
        throw Error(name_of_scene(a),
                    cages.empty() ? "has no cage to test" : "none of its cages can be tested, so nothing was shown");
    return 0;
}

}  // namespace occam::command
