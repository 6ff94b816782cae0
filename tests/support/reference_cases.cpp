#include "tests/support/reference_cases.h"

#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "render/image.h"
#include "tests/support/shared_data.h"

namespace occam::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Vec3d vector_of(const json& numbers)
{
    return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}

// Reads a tolerance of the form {"<unit>": limit, "share": least}.
void read_tolerance(const json& tolerance, const char* layer, const char* unit, double& limit, std::optional<double>& least)
{
    if (!tolerance.contains(layer)) return;
    limit = tolerance[layer].at(unit).get<double>();
    least = tolerance[layer].at("share").get<double>();
}

BoundaryRule boundary_of(const json& from)
{
    const auto rule = from.at("boundary_rule").get<std::string>();
    if (rule == "edge and corner") return BoundaryRule::EdgeAndCorner;
    if (rule == "edge only") return BoundaryRule::EdgeOnly;
    throw Error("cases.json", "unknown boundary rule '" + rule + "'", from.at("id").get<std::string>());
}

ReferenceCase case_of(const json& from, const fs::path& shared)
{
    ReferenceCase c;
    c.id = from.at("id");
    c.model = shared / "data" / from.at("model").get<std::string>();
    c.is_subdivision = from.at("kind") == "subdivision";
    if (c.is_subdivision) {
        c.boundary = boundary_of(from);
    } else if (from.at("pose") != "static") {
        c.clip = from.at("clip_index");
        c.seconds = from.at("time");
    }
    c.width = from.at("size").at(0);
    c.height = from.at("size").at(1);
    constexpr double kRadians = 0.017453292519943295;  // radians in a degree
    c.camera = Camera::look_at(vector_of(from.at("eye")), vector_of(from.at("target")), vector_of(from.at("up")),
                               static_cast<float>(from.at("vfov_degrees").get<double>() * kRadians));
    for (const auto& [layer, file] : from.at("files").items())
        c.files[layer] = shared / "reference" / file.get<std::string>();

    const json& t = from.at("tolerance");
    read_tolerance(t, "depth", "relative", c.limits.depth_relative, c.least.depth);
    read_tolerance(t, "normal_geometric", "degrees", c.limits.normal_geometric_degrees, c.least.normal_geometric);
    read_tolerance(t, "normal_shading", "degrees", c.limits.normal_shading_degrees, c.least.normal_shading);
    read_tolerance(t, "uv", "absolute", c.limits.uv_absolute, c.least.uv);
    c.least.coverage_mismatch = t.at("coverage").at("max_mismatch_share_of_hit");
    if (t.contains("albedo")) {
        c.least.albedo = t["albedo"].at("share_within_0_05").get<double>();
        c.least.albedo_mean_absolute = t["albedo"].at("mean_absolute").get<double>();
    }
    return c;
}

}  // namespace

std::vector<ReferenceCase> reference_cases()
{
    const fs::path shared = shared_data(), file = shared / "reference" / "cases.json";
    std::vector<ReferenceCase> cases;
    if (shared.empty() || !fs::exists(file)) return cases;
    try {
        std::ifstream in(file);
        const json all = json::parse(in);
        for (const json& c : all.at("cases")) cases.push_back(case_of(c, shared));
    } catch (const json::exception& e) {
        throw Error(file.string(), e.what(), "case " + std::to_string(cases.size()));
    }
    return cases;
}

ReferencePicture read_reference(const ReferenceCase& c)
{
    ReferencePicture picture;
    picture.width = c.width;
    picture.height = c.height;
    const auto read = [&](const char* layer, std::size_t channels) -> std::vector<float> {
        const auto file = c.files.find(layer);
        if (file == c.files.end()) return {};
        render::Image image = render::Image::read(file->second);
        std::vector<float> pixels = std::move(image.layer(0).pixels);
        if (image.width != c.width || image.height != c.height || pixels.size() != channels * picture.pixel_count())
            throw Error(file->second.string(), "has not the size or the channels that its case says", c.id);
        return pixels;
    };
    picture.depth = read("depth", 1);
    picture.normal_geometric = read("normal_geometric", 3);
    picture.normal_shading = read("normal_shading", 3);
    picture.albedo = read("albedo", 4);
    picture.uv = read("uv", 2);
    for (float v : read("exclude", 1)) picture.exclude.push_back(v > 0.5f);
    return picture;
}

std::string reference_test_name(const ReferenceCase& c)
{
    std::string name = c.id;
    for (char& letter : name)
        if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '_';
    return name;
}

}  // namespace occam::test
