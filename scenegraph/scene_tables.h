// The tables behind the handles of a Scene, the lists of who uses what, and the undoing of half an edit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include "base/handle.h"
#include "scenegraph/ids.h"

namespace occam {

/// The nodes, cages or skins that an edit must notify. Removed ones and duplicates are dropped when the list would grow, so
/// that its size stays in proportion to the number alive at one time.
template <class Id>
class WatcherList {
public:
    template <class IsAlive>
    void add(Id id, IsAlive&& is_alive)
    {
        if (!ids_.empty() && ids_.back() == id) return;
        if (ids_.size() == ids_.capacity()) {
            std::erase_if(ids_, [&](Id known) { return !is_alive(known); });
            std::sort(ids_.begin(), ids_.end(), [](Id a, Id b) { return a.slot < b.slot; });  // live ids differ by slot
            ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
            if (ids_.size() > ids_.capacity() / 2) ids_.reserve(2 * ids_.capacity());
        }
        ids_.push_back(id);
    }
    const std::vector<Id>& ids() const noexcept { return ids_; }
    /// Drops the ids that watch no longer, and returns the others.
    template <class Watches>
    const std::vector<Id>& those_that(Watches&& watches) noexcept
    {
        std::erase_if(ids_, [&](Id id) { return !watches(id); });
        return ids_;
    }
    /// Returns whether any id still watches. Ids at the end that watch no longer are dropped, so the mean cost is constant.
    template <class Watches>
    bool has_any_that(Watches&& watches) noexcept
    {
        while (!ids_.empty() && !watches(ids_.back())) ids_.pop_back();
        return !ids_.empty();
    }

private:
    std::vector<Id> ids_;
};
using Watchers = WatcherList<NodeId>;

/// Returns the first generation for the handles of a new scene: far from that of every other scene of the process.
std::uint32_t next_scene_generation() noexcept;

/// A SlotMap whose generations start at a number of the scene's own, so that it does not accept another scene's handles. For
/// a foreign handle to be accepted, a slot would have to be reused as often as the difference of the two numbers.
template <class T, class Tag>
class SceneTable {
public:
    using Id = Handle<Tag>;

    explicit SceneTable(std::uint32_t first_generation) noexcept : first_(first_generation) {}

    Id add(T value)
    {
        const Id id = outer(map_.add(std::move(value)));
        ++size_;
        return id;
    }
    /// Removes the value. A dead handle has no effect. Without memory to remember the free slot, the slot is not used again.
    void remove(Id id) noexcept
    {
        if (!find(id)) return;
        --size_;
        try {
            map_.remove(inner(id));
        } catch (const std::bad_alloc&) {
        }
    }
    T* find(Id id) noexcept { return map_.find(inner(id)); }
    const T* find(Id id) const noexcept { return map_.find(inner(id)); }
    std::size_t size() const noexcept { return size_; }
    template <class Visit>
    void for_each(Visit&& visit) const
    {
        map_.for_each([&](Id id, const T& value) { visit(outer(id), value); });
    }
    template <class Visit>
    void for_each(Visit&& visit)
    {
        map_.for_each([&](Id id, const T&) { visit(outer(id), *map_.find(id)); });
    }

private:
    Id outer(Id id) const noexcept { return {id.slot, id.generation + first_}; }
    Id inner(Id id) const noexcept { return {id.slot, id.generation - first_}; }

    SlotMap<T, Tag> map_;
    std::uint32_t first_;
    std::size_t size_ = 0;
};

/// Undoes the first steps of an edit if a later one throws: an edit is done as a whole or not at all.
template <class Undo>
class Rollback {
public:
    explicit Rollback(Undo undo) : undo_(std::move(undo)) {}
    ~Rollback()
    {
        if (!is_done_) undo_();
    }
    Rollback(const Rollback&) = delete;
    Rollback& operator=(const Rollback&) = delete;

    /// Keeps what was done.
    void keep() noexcept { is_done_ = true; }

private:
    Undo undo_;
    bool is_done_ = false;
};

}  // namespace occam
