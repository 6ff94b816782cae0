#include "io/import/gltf_instancing.h"

#include <array>
#include <cmath>
#include <unordered_set>

#include "base/hash.h"
#include "io/import/gltf_value.h"

namespace occam::import {

std::vector<Trs> instance_places(const tinygltf::Node& node, AccessorReader& accessors, std::size_t left, Report& report,
                                 const std::string& where)
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
    for (const std::string& name : attributes.Keys())
        if (name != "TRANSLATION" && name != "ROTATION" && name != "SCALE" && !name.starts_with("_"))
            report.warn("unknown attribute '" + name.substr(0, 64) + "'", where + ".EXT_mesh_gpu_instancing");
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

std::size_t remove_equal(std::vector<Trs>& places)
{
    using Key = std::array<double, 10>;
    const auto key_of = [](const Trs& p) {
        const Vec3d &t = p.translation, &s = p.scale;
        const Vec4d& r = p.rotation;
        return Key{t.x, t.y, t.z, r.x, r.y, r.z, r.w, s.x, s.y, s.z};
    };
    const auto hash = [](const Key& key) { return static_cast<std::size_t>(fnv1a(key.data(), sizeof key)); };
    std::unordered_set<Key, decltype(hash)> known(places.size(), hash);
    return std::erase_if(places, [&](const Trs& place) { return !known.insert(key_of(place)).second; });
}

double overlap_of(const std::vector<Trs>& places, const Box3d& shape)
{
    if (shape.is_empty()) return 0;
    const auto half_area = [](const Box3d& box) {
        const Vec3d e = box.hi - box.lo;
        return e.x * e.y + e.y * e.z + e.z * e.x;
    };
    Box3d all;
    double sum = 0;
    for (const Trs& place : places) {
        const Box3d box = transform_box(place.matrix(), shape);
        if (box.is_empty()) continue;
        all.add(box.lo);
        all.add(box.hi);
        sum += half_area(box);
    }
    const double whole = all.is_empty() ? 0 : half_area(all);
    return whole > 0 ? sum / whole : 0;
}

}  // namespace occam::import
