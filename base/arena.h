// Allocates memory that is released all at once: it holds what a worker builds for a frame.
//
// Memory   chunks of 256 KiB, kept across a reset() so that the next frame needs no memory from the system. An allocation of
//          more than a quarter of a chunk has a block of its own, which is not kept. So at most a quarter of what is held
//          is not counted by bytes(). Chunks and larger blocks are kept for other arenas (base/kept_blocks.h).
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

#include "base/kept_blocks.h"
#include "base/publish.h"

namespace occam {

class Arena {
public:
    static constexpr std::size_t kChunkBytes = 256 << 10;
    static constexpr std::size_t kLargeBytes = kChunkBytes / 4;
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
        if (chunks_.size() > keep_bytes / kChunkBytes) chunks_.resize(keep_bytes / kChunkBytes);
        large_.clear();
        current_ = 0;
        used_ = 0;
        owed_ = 0;
        publish(bytes_, std::size_t(0));
    }

private:
    struct Free {
        std::size_t kept = 0;  ///< bytes; 0: the block is from the heap
        void operator()(std::byte* p) const noexcept
        {
            if (kept > 0) kept_blocks::give(p, kept);
            else ::operator delete(p, std::align_val_t(kAlign));
        }
    };
    using Block = std::unique_ptr<std::byte[], Free>;
    static Block block(std::size_t bytes)
    {
        if (bytes < kChunkBytes) return Block(static_cast<std::byte*>(::operator new(bytes, std::align_val_t(kAlign))));
        const kept_blocks::Block taken = kept_blocks::take(bytes);
        if (taken.is_fresh && bytes == kChunkBytes) populate(taken.data, bytes);
        return Block(taken.data, Free{bytes});
    }

    // Asks the system for all pages of a new chunk at once, because a page fault for each of them takes longer than filling
    // it. Nothing depends on whether the system does so.
    static void populate(std::byte* from, std::size_t bytes) noexcept;

    // Blocks of their own keep large allocations from leaving large parts of chunks unused, or whole chunks after a reset:
    // the arena would hold twice the bytes that it counts.
    void* allocate(std::size_t bytes)
    {
        bytes = (bytes + kAlign - 1) & ~(kAlign - 1);
        publish(bytes_, bytes_ + bytes);
        if (bytes > kLargeBytes) {
            // Chunks that are not used yet make room for such blocks.
            for (owed_ += bytes; owed_ >= kChunkBytes && chunks_.size() > current_ + 1; owed_ -= kChunkBytes)
                chunks_.pop_back();
            return large_.emplace_back(block(bytes)).get();
        }
        if (current_ < chunks_.size() && used_ + bytes > kChunkBytes) {
            ++current_;
            used_ = 0;
        }
        if (current_ == chunks_.size()) chunks_.push_back(block(kChunkBytes));
        std::byte* p = chunks_[current_].get() + used_;
        used_ += bytes;
        return p;
    }

    std::vector<Block> chunks_, large_;
    std::size_t current_ = 0, used_ = 0, bytes_ = 0;
    std::size_t owed_ = 0;  ///< bytes of large blocks for which no chunk has made room
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
