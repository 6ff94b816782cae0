// An image as the application or a file gives it: encoded bytes or a path, and its role. The texture store decodes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/vec.h"

namespace occam {

/// Says what the texels mean. Colours are sRGB in files of integers and linear in files of floats; data are linear in both.
enum class TextureRole : std::uint8_t { Color, Data };

struct Texture {
    std::string name{};
    TextureRole role = TextureRole::Color;
    std::filesystem::path path{};                             ///< a file, if `encoded` and `pixels` are empty
    std::shared_ptr<const std::vector<std::byte>> encoded{};  ///< a whole image file in memory (GLB, data URI)
    std::vector<Vec4f> pixels{};                              ///< or linear RGBA, row-major from the top left
    int width = 0, height = 0;                                ///< size of `pixels`
    std::uint64_t identity = 0;  ///< unique in the process; given by Scene::add and Scene::replace, each time a new one
};

}  // namespace occam
