// Allocates memory that is released all at once: it holds what a worker builds for a frame.
//
// Memory   chunks of 256 KiB and more, kept across a reset() so that the next frame needs no memory from the system.
// Threads  one owner at a time; other threads may call bytes() and read an ArenaVector's elements at the same time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

#include "base/publish.h"

namespace occam {

class Arena {
public:
    static constexpr std::size_t kChunkBytes = 256 << 10;
    static constexpr std::size_t kAlign = 32;  ///< the size of an eight-lane vector

    /// Returns uninitialised room for `count` elements of T, aligned to kAlign. T must be trivially destructible, because
    /// nothing is destroyed.
    template <class T>
    std::span<T> make_array(std::size_t count)
    {
        static_assert(std::is_trivially_destructible_v<T>);
        return {static_cast<T*>(allocate(count * sizeof(T))), count};
    }
    template <class T, class... Args>
    T* make(Args&&... args)
    {
        static_assert(std::is_trivially_destructible_v<T>);
        return new (allocate(sizeof(T))) T{static_cast<Args&&>(args)...};
    }

    /// Returns the number of bytes allocated since the last reset.
    std::size_t bytes() const noexcept { return read_published(bytes_); }

    /// Releases everything. Chunks are kept, except those beyond `keep_bytes`.
    void reset(std::size_t keep_bytes = ~std::size_t(0))
    {
        std::size_t kept = 0, chunks = 0;
        while (chunks < chunks_.size() && kept + chunks_[chunks].size <= keep_bytes) kept += chunks_[chunks++].size;
        chunks_.resize(chunks);
        current_ = 0;
        used_ = 0;
        publish(bytes_, std::size_t(0));
    }

private:
    struct Free {
        void operator()(std::byte* p) const noexcept { ::operator delete(p, std::align_val_t(kAlign)); }
    };
    struct Chunk {
        std::unique_ptr<std::byte[], Free> data;
        std::size_t size;
    };

    void* allocate(std::size_t bytes)
    {
        bytes = (bytes + kAlign - 1) & ~(kAlign - 1);
        publish(bytes_, bytes_ + bytes);
        while (current_ < chunks_.size() && used_ + bytes > chunks_[current_].size) {
            ++current_;
            used_ = 0;
        }
        if (current_ == chunks_.size()) {
            const std::size_t size = bytes > kChunkBytes ? bytes : kChunkBytes;
            chunks_.push_back(
                {std::unique_ptr<std::byte[], Free>(static_cast<std::byte*>(::operator new(size, std::align_val_t(kAlign)))),
                 size});
        }
        std::byte* p = chunks_[current_].data.get() + used_;
        used_ += bytes;
        return p;
    }

    std::vector<Chunk> chunks_;
    std::size_t current_ = 0, used_ = 0, bytes_ = 0;
};

/// A growing list in an arena, in pieces, so that elements never move. One thread adds elements; others may read elements
/// whose index was published to them at the same time.
template <class T>
class ArenaVector {
public:
    static_assert(std::is_trivially_copyable_v<T>);

    static constexpr std::size_t kPiece = 512;  ///< elements; memory is allocated for this many at a time

    explicit ArenaVector(Arena& arena) : arena_(&arena) {}

    T& push_back(const T& value)
    {
        if ((size_ & kMask) == 0) {
            if (size_ >> kShift == room_) grow();
            pieces_[size_ >> kShift] = arena_->make_array<T>(kPiece).data();
        }
        return (*this)[size_++] = value;
    }
    T& operator[](std::size_t i) noexcept { return read_published(pieces_)[i >> kShift][i & kMask]; }
    const T& operator[](std::size_t i) const noexcept { return read_published(pieces_)[i >> kShift][i & kMask]; }
    std::size_t size() const noexcept { return size_; }
    /// Forgets its elements and its memory; call it after the arena was reset.
    void clear() noexcept
    {
        pieces_ = nullptr;
        size_ = room_ = 0;
    }

private:
    static constexpr std::size_t kShift = 9, kMask = kPiece - 1;

    // A larger table of pieces leaves the smaller one in place, because another thread may be reading it.
    void grow()
    {
        room_ = room_ == 0 ? 16 : 2 * room_;
        T** larger = arena_->make_array<T*>(room_).data();
        std::copy_n(pieces_, size_ >> kShift, larger);
        publish(pieces_, larger);
    }

    Arena* arena_;
    T** pieces_ = nullptr;
    std::size_t size_ = 0, room_ = 0;  ///< elements; pieces
};

}  // namespace occam
