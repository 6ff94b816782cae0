// Bytes of pictures as the streams of OpenEXR's library; for the source files that use it alone.
#pragma once

#include <Iex.h>
#include <IlmThreadPool.h>
#include <ImfIO.h>

#include <cstdint>

#include "io/picture_codec.h"
#include "io/texture/image_header.h"

namespace occam {

// Returns the number of threads with which the library does all work in the calling thread. It makes the library's pool of
// threads first. The library would make it after a group of tasks has begun, which waits for ever if there is no memory for
// it.
inline int no_threads()
{
    IlmThread::ThreadPool::globalThreadPool();
    return 0;
}

// Hands the bytes of the encoder on. Failures are remembered by the receiver.
class ExrOutput final : public Imf::OStream {
public:
    explicit ExrOutput(PictureBytes& to) : OStream("picture"), to_(to) {}

    void write(const char* bytes, int size) override
    {
        to_.write_at(bytes, static_cast<std::size_t>(size), at_);
        at_ += static_cast<std::uint64_t>(size);
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t position) override { at_ = position; }

private:
    PictureBytes& to_;
    std::uint64_t at_ = 0;
};

class ExrInput final : public Imf::IStream {
public:
    explicit ExrInput(ImageBytes& from) : IStream("picture"), from_(from) {}

    bool read(char* to, int size) override
    {
        const auto count = static_cast<std::size_t>(size);
        if (!from_.read(at_, {reinterpret_cast<unsigned char*>(to), count})) throw Iex::InputExc("the file is cut off");
        at_ += count;
        return at_ < from_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t position) override { at_ = position; }

private:
    ImageBytes& from_;
    std::uint64_t at_ = 0;
};

}  // namespace occam
