#include "render/file_colors.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace occam::render {
namespace {

std::uint32_t number_at(const unsigned char* bytes)
{
    return std::uint32_t(bytes[0]) << 24 | std::uint32_t(bytes[1]) << 16 | std::uint32_t(bytes[2]) << 8 | bytes[3];
}

}  // namespace

float png_power(ImageBytes& file)
{
    constexpr std::uintmax_t kSignature = 8, kAround = 12;  // the bytes of a chunk that are not its data
    constexpr float kSrgb = 2.2f;
    float power = 0;
    std::array<unsigned char, kAround> chunk{};  // its size, its name and what its data begin with
    for (std::uintmax_t at = kSignature; file.read(at, chunk); at += kAround + number_at(chunk.data())) {
        const std::string_view name(reinterpret_cast<const char*>(&chunk[4]), 4);
        if (name == "sRGB" || name == "iCCP" || name == "cICP") return 0;
        if (name == "IDAT") break;
        const std::uint32_t gamma = number_at(&chunk[8]);
        if (name == "gAMA" && gamma > 0) power = 100'000 / static_cast<float>(gamma);
    }
    return std::abs(power - kSrgb) < 0.02f ? 0 : power;
}

}  // namespace occam::render
