// Typed generational handles, and the table that issues them.
//
// A handle names a slot and the generation of the value in it. A removal advances the slot's generation, so that an old
// handle is known to be dead. The tag is part of the type, so handles of two kinds cannot be confused.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace occam {

template <class Tag>
struct Handle {
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    std::uint32_t slot = kNone;
    std::uint32_t generation = 0;

    explicit operator bool() const noexcept { return slot != kNone; }
    friend bool operator==(Handle, Handle) = default;
};

/// Stores values by handle. Slots are reused, and values stay in place only until the next add().
template <class T, class Tag>
class SlotMap {
public:
    using Id = Handle<Tag>;

    Id add(T value)
    {
        if (!free_.empty()) {
            const std::uint32_t slot = free_.back();
            free_.pop_back();
            slots_[slot].value = std::move(value);
            return {slot, slots_[slot].generation};
        }
        slots_.push_back({std::move(value), 0});
        return {static_cast<std::uint32_t>(slots_.size() - 1), 0};
    }
    /// Removes the value. A dead handle has no effect.
    void remove(Id id)
    {
        if (!find(id)) return;
        slots_[id.slot].value.reset();
        ++slots_[id.slot].generation;
        free_.push_back(id.slot);
    }
    /// Returns the value, or null if the handle is dead.
    T* find(Id id) noexcept
    {
        return id.slot < slots_.size() && slots_[id.slot].generation == id.generation && slots_[id.slot].value
                   ? &*slots_[id.slot].value
                   : nullptr;
    }
    const T* find(Id id) const noexcept { return const_cast<SlotMap*>(this)->find(id); }

    std::size_t size() const noexcept { return slots_.size() - free_.size(); }

    /// Calls visit(Id, const T&) for all live values, in the order of their slots.
    template <class Visit>
    void for_each(Visit&& visit) const
    {
        for (std::uint32_t s = 0; s < slots_.size(); ++s)
            if (slots_[s].value) visit(Id{s, slots_[s].generation}, *slots_[s].value);
    }

private:
    struct Slot {
        std::optional<T> value;
        std::uint32_t generation = 0;
    };
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;
};

}  // namespace occam

template <class Tag>
struct std::hash<occam::Handle<Tag>> {
    std::size_t operator()(occam::Handle<Tag> id) const noexcept
    {
        return std::hash<std::uint64_t>{}((std::uint64_t(id.generation) << 32) | id.slot);
    }
};
