#include "tests/support/shapes.h"

#include <algorithm>
#include <filesystem>

#include "io/import/import.h"
#include "tests/support/campaign.h"
#include "tests/support/made_cages.h"
#include "tests/support/shared_data.h"
#include "verify/verify.h"

namespace occam::test {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kMade = "made:";

/// Returns the names of the made cages, and after them `files` in order.
std::vector<std::string> made_and(std::vector<std::string> files, bool only_closed)
{
    std::vector<std::string> names;
    for (const MadeCage& made : made_cages())
        if (made.is_closed || !only_closed) names.push_back(std::string(kMade) + made.name);
    std::sort(files.begin(), files.end());
    names.insert(names.end(), files.begin(), files.end());
    return names;
}

}  // namespace

std::vector<std::string> subdivision_shapes()
{
    std::vector<std::string> paths;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(shared_data() / "data/subdiv/opensubdiv", none)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("catmark_") || name.starts_with("bilinear_")) paths.push_back(entry.path().string());
    }
    return made_and(std::move(paths), false);
}

// The shapes are found once: several suites have them as parameters, and each file has to be read.
const std::vector<std::string>& closed_shapes()
{
    static const std::vector<std::string> shapes = [] {
        std::vector<std::string> paths;
        std::error_code none;
        for (const auto& entry : fs::recursive_directory_iterator(shared_data() / "data/subdiv", none)) {
            const fs::path& path = entry.path();
            if (path.extension() != ".obj" || path.string().find("opensubdiv_reference") != std::string::npos) continue;
            if (path.filename().string().starts_with("loop_")) continue;
            if (why_not_closed(load_cage(path.string())).empty()) paths.push_back(path.string());
        }
        return made_and(std::move(paths), true);
    }();
    return shapes;
}

std::vector<std::string> chosen_closed_shapes()
{
    if (is_long()) return closed_shapes();
    std::vector<std::string> names;
    for (const char* name : {"cube", "tetrahedron", "house", "pyramid", "torus", "prism_7", "prism_40", "pole_9", "pole_64",
                             "quad_pole_8", "cells_ring", "ball_quads_and_triangles", "house_bilinear", "cube_creases_2_75",
                             "cube_creases_infinite", "cube_dart", "cube_corners", "pole_9_creases"})
        names.push_back(std::string(kMade) + name);
    const fs::path folder = shared_data() / "data/subdiv";
    for (const char* file : {"found/refined_pyramid.obj", "opensubdiv/catmark_smoothtris1.obj", "chess/Rook.obj"})
        if (fs::exists(folder / file)) names.push_back((folder / file).string());
    return names;
}

std::vector<std::string> closed_cages_without_creases()
{
    constexpr std::size_t kFew = 60;
    std::vector<std::string> names;
    for (const auto& [name, cage, is_closed] : made_cages())
        if (is_closed && cage.creases.empty() && cage.corners.empty() && (is_long() || cage.face_count() <= kFew))
            names.push_back(std::string(kMade) + name);
    return names;
}

Cage load_cage(const std::string& name)
{
    if (name.starts_with(kMade)) return made_cage(name.substr(kMade.size()));
    const Scene scene = load(name, {.subdivide = Subdivide::On});
    Cage cage;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        for (const CageId id : node.cages) cage = scene.cage(id).cage;
    });
    cage.scheme = fs::path(name).filename().string().starts_with("bilinear_") ? Scheme::Bilinear : Scheme::CatmullClark;
    return cage;
}

std::string shape_test_name(const testing::TestParamInfo<std::string>& info)
{
    std::string name = fs::path(info.param).stem().string();
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return name;
}

}  // namespace occam::test
