#include "io/import/gltf_size.h"

#include <nlohmann/json.hpp>
#include <string>

#include "io/import/gltf_json.h"

namespace occam::import {

namespace {

// What an element without any property takes in all: parsed, as tinygltf keeps it, and in the scene.
struct ListCost {
    const char* list;
    std::size_t bytes;
};
constexpr ListCost kCosts[] = {{"nodes", 1700},   {"materials", 3200}, {"textures", 800},  {"samplers", 600},
                               {"scenes", 800},   {"images", 1200},    {"skins", 1500},    {"meshes", 1200},
                               {"cameras", 1800}, {"animations", 800}, {"accessors", 800}, {"bufferViews", 600}};

// Elements that say something are longer: a node with a mesh and a place has 40 bytes of text and more.
constexpr std::size_t kAlwaysAllowed = std::size_t(2) << 30, kMostPerByte = 64;

}  // namespace

void check_size(const nlohmann::json& root, std::size_t text_bytes, const Report& report)
{
    std::size_t sum = 0, most = 0;
    std::string longest;
    for (const auto& [name, bytes] : kCosts) {
        const std::size_t cost = bytes * list(root, name).size();
        sum += cost;
        if (cost <= most) continue;
        most = cost;
        longest = name;
    }
    if (sum <= kAlwaysAllowed + kMostPerByte * text_bytes) return;
    throw Error(report.name(),
                "the lists have so many elements that they would take about " + std::to_string(sum >> 20) +
                    " MB of memory, far more than " + std::to_string(text_bytes >> 10) + " KB of text explain",
                longest);
}

}  // namespace occam::import
