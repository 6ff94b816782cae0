// Receives the bytes of an encoder in memory.
#pragma once

#include <algorithm>
#include <string>

#include "io/picture_codec.h"

namespace occam::test {

class BytesInMemory final : public PictureBytes {
public:
    std::string all;

    void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept override
    {
        if (all.size() < offset + size) all.resize(offset + size);
        std::copy_n(static_cast<const char*>(bytes), size, all.begin() + std::ptrdiff_t(offset));
    }
    std::size_t read_at(void*, std::size_t, std::uint64_t) const noexcept override { return 0; }
    std::uint64_t size() const noexcept override { return all.size(); }
};

}  // namespace occam::test
