// Short lookups in a JSON document that has passed check_schema().
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace occam::import {

/// Returns the array of that name at the top level, or an empty one if there is none.
inline const nlohmann::json& list(const nlohmann::json& object, const char* key)
{
    static const nlohmann::json none = nlohmann::json::array();
    const auto found = object.find(key);
    return found == object.end() ? none : *found;
}
inline std::int64_t integer(const nlohmann::json& object, const char* key, std::int64_t otherwise)
{
    const auto found = object.find(key);
    return found == object.end() ? otherwise : static_cast<std::int64_t>(found->get<double>());
}
inline std::string text(const nlohmann::json& object, const char* key)
{
    const auto found = object.find(key);
    return found == object.end() || !found->is_string() ? std::string() : found->get<std::string>();
}
inline std::string element(const char* kind, std::size_t index)
{
    return std::string(kind) + "[" + std::to_string(index) + "]";
}

}  // namespace occam::import
