// The bytes of an encoder on their way to a file.
#pragma once

#include "io/output_file.h"
#include "io/picture_codec.h"

namespace occam {

/// Receives the bytes of encoders for a file. Some of their libraries end the process when a write fails, and some ignore
/// it. So they are told that every write succeeded, and OutputFile::finish() reports what failed.
class EncodedBytes final : public PictureBytes {
public:
    explicit EncodedBytes(OutputFile& file) : file_(file) {}

    void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept override
    {
        file_.write_at(bytes, size, offset);
    }
    std::size_t read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept override
    {
        return file_.read_at(bytes, size, offset);
    }
    std::uint64_t size() const noexcept override { return file_.size(); }

private:
    OutputFile& file_;
};

}  // namespace occam
