#include "io/import/gltf_instancing.h"

#include <cmath>

#include "io/import/gltf_value.h"

namespace occam::import {

std::vector<Trs> instance_places(const tinygltf::Node& node, AccessorReader& accessors, std::size_t left,
                                 const Report& report, const std::string& where)
{
    const tinygltf::Value& attributes = member(extension(node.extensions, "EXT_mesh_gpu_instancing"), "attributes");
    const auto refuse = [&](const std::string& what) {
        throw Error(report.name(), what, where + ".EXT_mesh_gpu_instancing");
    };
    std::vector<Trs> places;
    const auto values = [&](const char* name, int width) {
        const int accessor = integer(attributes, name, -1);
        if (accessor < 0) return std::vector<float>();
        const std::size_t count = accessors.count(accessor);
        if (count > left) refuse("a file may have at most " + std::to_string(kMaxInstances) + " instances");
        if (accessors.components(accessor) != width) refuse(std::string(name) + " has the wrong type");
        if (!places.empty() && places.size() != count) refuse("the attributes differ in their number of instances");
        places.resize(count);
        return accessors.floats(accessor, width);
    };
    const std::vector<float> translation = values("TRANSLATION", 3), rotation = values("ROTATION", 4),
                             scale = values("SCALE", 3);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto vector = [&](const std::vector<float>& v) { return Vec3d(v[3 * i], v[3 * i + 1], v[3 * i + 2]); };
        if (!translation.empty()) places[i].translation = vector(translation);
        if (!scale.empty()) places[i].scale = vector(scale);
        if (rotation.empty()) continue;
        const float* q = &rotation[4 * i];
        const Vec4d turn(q[0], q[1], q[2], q[3]);
        const double length = std::sqrt(glm::dot(turn, turn));
        if (length > 0 && std::isfinite(length)) places[i].rotation = turn / length;
    }
    return places;
}

}  // namespace occam::import
