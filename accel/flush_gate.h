// Lets one of several workers drop the data that all of them use. Each worker is inside the gate while it works, and
// steps out at its safe points when it is asked to. If the data cannot be made anew after they were dropped, all workers
// stop as if their frame were cancelled, but for the one whose error it is.
//
// Threads  Any thread may call it.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <shared_mutex>

#include "base/cancellation.h"

namespace occam::accel {

class FlushGate {
public:
    /// Keeps a worker inside the gate for a scope. A null gate means that no other worker uses the data.
    class Inside {
    public:
        explicit Inside(FlushGate* gate) : gate_(gate)
        {
            if (!gate_) return;
            gate_->enter();
            if (!gate_->is_broken_) return;
            gate_->leave();
            throw Cancelled();
        }
        ~Inside()
        {
            if (gate_) gate_->leave();
        }
        Inside(const Inside&) = delete;
        Inside& operator=(const Inside&) = delete;

    private:
        FlushGate* gate_;
    };

    /// Marks a safe point of a worker that is inside. During the call another worker may drop the data, so afterwards
    /// nothing that was found in them before is valid. Throws Cancelled if they could not be made anew.
    void pass()
    {
        if (!is_wanted_.load(std::memory_order_relaxed)) return;
        leave();
        enter();
        if (is_broken_) throw Cancelled();
    }
    /// Returns the number of flushes so far. A worker that is inside sees the same value until its next safe point.
    std::uint64_t flushes() const noexcept { return flushes_; }
    /// Waits until no worker is inside and calls drop(), unless another worker has done so since flushes() was `seen`.
    /// The caller is inside before and after, also if drop() throws; the call is a safe point, as pass().
    template <class Drop>
    void flush(std::uint64_t seen, Drop&& drop)
    {
        const Outside outside(*this);
        const std::lock_guard turn(turn_);
        if (is_broken_) throw Cancelled();
        if (flushes_ != seen) return;
        is_wanted_.store(true, std::memory_order_relaxed);
        const std::lock_guard while_empty(inside_);
        drop_and_count(drop);
    }
    /// Waits until no worker is inside, calls drop() and then work(), and returns its result. No other worker is inside
    /// before work() has ended. The rest is as for flush().
    template <class Drop, class Work>
    auto alone(Drop&& drop, Work&& work)
    {
        const Outside outside(*this);
        const std::lock_guard turn(turn_);
        if (is_broken_) throw Cancelled();
        is_wanted_.store(true, std::memory_order_relaxed);
        const std::lock_guard while_empty(inside_);
        drop_and_count(drop);
        return work();
    }

private:
    template <class Drop>
    void drop_and_count(Drop& drop)
    {
        is_broken_ = true;
        drop();
        is_broken_ = false;
        ++flushes_;
        is_wanted_.store(false, std::memory_order_relaxed);
    }

    /// Keeps a worker that is inside out for a scope.
    class Outside {
    public:
        explicit Outside(FlushGate& gate) : gate_(gate) { gate_.leave(); }
        ~Outside() { gate_.enter(); }
        Outside(const Outside&) = delete;
        Outside& operator=(const Outside&) = delete;

    private:
        FlushGate& gate_;
    };

    // Takes the turn first, so that a worker that waits to flush keeps others from entering.
    void enter()
    {
        const std::lock_guard turn(turn_);
        inside_.lock_shared();
    }
    void leave() { inside_.unlock_shared(); }

    std::mutex turn_;  ///< held by a worker that enters or flushes, and by one that works alone
    std::shared_mutex inside_;
    std::atomic<bool> is_wanted_ = false;
    std::uint64_t flushes_ = 0;  ///< written while no worker is inside
    bool is_broken_ = false;     ///< written while no worker is inside
};

}  // namespace occam::accel
