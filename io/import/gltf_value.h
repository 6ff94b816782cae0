// Typed lookups in the free-form parts of a glTF: extensions and extras.
#pragma once

#include <tiny_gltf.h>

#include <optional>
#include <string>

#include "base/vec.h"

namespace occam::import {

/// Returns how messages name an element of the file: its place, and its own name, which is cut off if it is very long.
inline std::string named_element(const char* kind, std::size_t index, const std::string& name)
{
    constexpr std::size_t kMostShown = 128;
    return std::string(kind) + "[" + std::to_string(index) + "]" +
           (name.empty() ? "" : " '" + name.substr(0, kMostShown) + "'");
}

/// Returns the extension of that name, or an empty value, which has no members.
inline const tinygltf::Value& extension(const tinygltf::ExtensionMap& extensions, const char* name)
{
    static const tinygltf::Value none;
    const auto found = extensions.find(name);
    return found == extensions.end() ? none : found->second;
}

inline const tinygltf::Value& member(const tinygltf::Value& value, const char* key)
{
    static const tinygltf::Value none;
    return value.Has(key) ? value.Get(key) : none;
}

inline float number(const tinygltf::Value& value, const char* key, float otherwise)
{
    const tinygltf::Value& x = member(value, key);
    return x.IsNumber() ? static_cast<float>(x.GetNumberAsDouble()) : otherwise;
}
inline int integer(const tinygltf::Value& value, const char* key, int otherwise)
{
    const tinygltf::Value& x = member(value, key);
    return x.IsInt() ? x.GetNumberAsInt() : otherwise;
}
inline std::string text(const tinygltf::Value& value, const char* key)
{
    const tinygltf::Value& x = member(value, key);
    return x.IsString() ? x.Get<std::string>() : std::string();
}
/// Returns the numbers of an array of exactly `Vec`'s length.
template <class Vec>
std::optional<Vec> vector(const tinygltf::Value& value, const char* key)
{
    const tinygltf::Value& x = member(value, key);
    if (!x.IsArray() || x.ArrayLen() != static_cast<std::size_t>(Vec::length())) return std::nullopt;
    Vec v;
    for (int i = 0; i < Vec::length(); ++i) {
        if (!x.Get(i).IsNumber()) return std::nullopt;
        v[i] = static_cast<typename Vec::value_type>(x.Get(i).GetNumberAsDouble());
    }
    return v;
}

/// Returns the numbers as a vector, or `otherwise` if they are not as many.
template <class Vec>
Vec vector_of(const std::vector<double>& numbers, Vec otherwise)
{
    if (numbers.size() != static_cast<std::size_t>(Vec::length())) return otherwise;
    for (int i = 0; i < Vec::length(); ++i)
        otherwise[i] = static_cast<typename Vec::value_type>(numbers[static_cast<std::size_t>(i)]);
    return otherwise;
}

}  // namespace occam::import
