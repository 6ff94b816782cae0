#include "tests/support/shapes.h"

#include <algorithm>
#include <filesystem>

#include "io/import/import.h"
#include "tests/support/shared_data.h"
#include "verify/verify.h"

namespace occam::test {
namespace fs = std::filesystem;

std::vector<std::string> subdivision_shapes()
{
    std::vector<std::string> paths;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(shared_data() / "data/subdiv/opensubdiv", none)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("catmark_") || name.starts_with("bilinear_")) paths.push_back(entry.path().string());
    }
    std::sort(paths.begin(), paths.end());
    return paths;
}

std::vector<std::string> closed_shapes()
{
    std::vector<std::string> paths;
    std::error_code none;
    for (const auto& entry : fs::recursive_directory_iterator(shared_data() / "data/subdiv", none)) {
        const fs::path& path = entry.path();
        if (path.extension() != ".obj" || path.string().find("opensubdiv_reference") != std::string::npos) continue;
        if (path.filename().string().starts_with("loop_")) continue;
        if (why_not_closed(load_cage(path.string())).empty()) paths.push_back(path.string());
    }
    std::sort(paths.begin(), paths.end());
    return paths;
}

Cage load_cage(const std::string& path)
{
    const Scene scene = load(path, {.subdivide = Subdivide::On});
    Cage cage;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        for (const CageId id : node.cages) cage = scene.cage(id).cage;
    });
    cage.scheme = fs::path(path).filename().string().starts_with("bilinear_") ? Scheme::Bilinear : Scheme::CatmullClark;
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
