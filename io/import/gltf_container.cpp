#include "io/import/gltf_container.h"

#include <array>
#include <limits>

namespace occam::import {

namespace {

constexpr std::size_t kHeader = 12, kChunkHeader = 8, kJson = 0x4e4f534a, kBin = 0x004e4942;

template <std::size_t N>
std::size_t u32(const std::array<char, N>& bytes, std::size_t at)
{
    std::uint32_t x = 0;
    for (std::size_t i = 4; i-- > 0;) x = x << 8 | static_cast<unsigned char>(bytes[at + i]);
    return x;
}

}  // namespace

GltfContainer::GltfContainer(const Report& report)
    : name_(report.name()), file_(report.file(), std::numeric_limits<std::uint32_t>::max())
{
    std::array<char, 4> magic{};
    if (file_.size() >= magic.size()) file_.read(0, magic);
    is_glb_ = std::string_view(magic.data(), magic.size()) == "glTF";
    if (is_glb_) {
        read_chunks();
    } else {
        json_.resize(file_.size());
        file_.read(0, json_);
    }
}

void GltfContainer::require(bool holds, const char* rule) const
{
    if (!holds) throw Error(name_, rule, "GLB container");
}

void GltfContainer::read_chunks()
{
    const std::size_t size = file_.size();
    require(size >= kHeader + kChunkHeader, "the header is cut off");
    std::array<char, kHeader> header{};
    file_.read(0, header);
    require(u32(header, 4) == 2, "only version 2 of the container is known");
    require(u32(header, 8) == size, "the declared length is not that of the file");
    for (std::size_t at = kHeader, index = 0; at < size; ++index) {
        require(size - at >= kChunkHeader, "a chunk header is cut off");
        std::array<char, kChunkHeader> chunk{};
        file_.read(at, chunk);
        const std::size_t length = u32(chunk, 0), type = u32(chunk, 4);
        at += kChunkHeader;
        require(length % 4 == 0, "a chunk's length is not a multiple of four");
        require(length <= size - at, "a chunk is longer than the file");
        require((index == 0) == (type == kJson), "the first chunk, and no other, must be JSON");
        require(type != kBin || index == 1, "the binary chunk must be the second one");
        if (type == kJson) {
            json_.resize(length);
            file_.read(at, json_);
        }
        if (type == kBin) binary_begin_ = at, binary_bytes_ = length;
        at += length;
    }
    require(!json_.empty(), "there is no JSON in it");
}

void GltfContainer::require_binary(std::size_t bytes) const
{
    require(bytes <= binary_bytes_, "the binary chunk is missing, or shorter than its buffer");
}

std::vector<unsigned char> GltfContainer::binary(std::size_t bytes) const
{
    require_binary(bytes);
    std::vector<unsigned char> out(bytes);
    file_.read(binary_begin_, {reinterpret_cast<char*>(out.data()), out.size()});
    return out;
}

}  // namespace occam::import
