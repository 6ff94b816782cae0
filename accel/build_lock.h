// The lock under which workers make a shared tree grow.
//
// A worker that runs out of memory in the middle leaves a part of the tree half made. The tree then counts as broken: it is
// made no further, and the other workers stop as if their frame were cancelled. Its error ends the frame.
//
// Threads  any thread may lock it.
#pragma once

#include <exception>
#include <mutex>

#include "base/cancellation.h"
#include "base/publish.h"

namespace occam::accel {

struct Building {
    std::mutex mutex;
    bool is_broken = false;  ///< guarded by the mutex
};

/// Locks the building of a tree for a scope, unless the tree belongs to one worker (null). Throws Cancelled if the tree is
/// broken.
class BuildLock {
public:
    explicit BuildLock(Building* building) : building_(building), lock_(building ? &building->mutex : nullptr)
    {
        if (building_ && building_->is_broken) throw Cancelled();
    }
    ~BuildLock()
    {
        if (building_ && std::uncaught_exceptions() > before_) building_->is_broken = true;
    }
    BuildLock(const BuildLock&) = delete;
    BuildLock& operator=(const BuildLock&) = delete;

private:
    Building* building_;
    const int before_ = std::uncaught_exceptions();
    MaybeLock lock_;
};

}  // namespace occam::accel
