// Bounds the memory of patch classes.
//
// A class reads its limit surface from a source, which OpenSubdiv makes. The source of a patch with semi-sharp creases, or
// of one with many control points, may take several megabytes, and a cage may have as many classes as patches. So these
// sources are pooled: those that were not used for longest are dropped, and made again if they are needed once more, which
// is rare once the tables of a class are filled. What the tables take is counted, and new classes are refused beyond a
// limit.
//
// Threads  any thread may call any function. A source is made under a lock of its own.
#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <mutex>

#include "lod/patch_class.h"

namespace occam::lod {

class ClassMemory : public ClassAccount {
public:
    /// The bytes of tables of classes from which on a new class is refused.
    static constexpr std::size_t kMostBytes = std::size_t(768) << 20;
    /// The bytes of pooled sources that are kept, as the sources say.
    static constexpr std::size_t kPoolBytes = std::size_t(256) << 20;

    explicit ClassMemory(std::size_t most_bytes = kMostBytes, std::size_t pool_bytes = kPoolBytes)
        : most_bytes_(most_bytes), pool_bytes_(pool_bytes)
    {
    }

    void add(std::size_t bytes) noexcept override { bytes_ += bytes; }
    void remove(std::size_t bytes) noexcept override { bytes_ -= bytes; }
    std::size_t bytes() const noexcept { return bytes_; }
    /// Throws Error if there is no room for another class.
    void check_room() const;

    using Make = std::function<std::unique_ptr<const LimitSource>()>;
    /// Returns a source that is made when it is first asked, and made again if it has been dropped. This object must outlive
    /// it.
    std::unique_ptr<const LimitSource> pooled(Make make);
    /// Returns the number of pooled sources that are kept now.
    std::size_t kept() const;

private:
    class Pooled;

    std::size_t most_bytes_, pool_bytes_;
    std::atomic<std::size_t> bytes_ = 0;
    mutable std::mutex mutex_;        // guards the members below, and what the pooled sources hold
    std::list<const Pooled*> order_;  // the source that was used last comes first
    std::size_t kept_bytes_ = 0;
};

/// Bytes that an object has told a ClassMemory, which forgets them with the object.
class CountedBytes {
public:
    explicit CountedBytes(ClassMemory& memory) noexcept : memory_(memory) {}
    ~CountedBytes() { memory_.remove(bytes_); }
    CountedBytes(const CountedBytes&) = delete;
    CountedBytes& operator=(const CountedBytes&) = delete;

    void add(std::size_t bytes) noexcept
    {
        bytes_ += bytes;
        memory_.add(bytes);
    }
    /// Throws Error if there is no room for more.
    void check_room() const { memory_.check_room(); }

private:
    ClassMemory& memory_;
    std::size_t bytes_ = 0;
};

}  // namespace occam::lod
