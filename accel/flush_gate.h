// Lets one of several workers drop the data that all of them use. Each worker is inside the gate while it works, and
// steps out at its safe points when it is asked to.
//
// Threads  Any thread may call it.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <shared_mutex>

namespace occam::accel {

class FlushGate {
public:
    /// Keeps a worker inside the gate for a scope. A null gate means that no other worker uses the data.
    class Inside {
    public:
        explicit Inside(FlushGate* gate) : gate_(gate)
        {
            if (gate_) gate_->enter();
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
    /// nothing that was found in them before is valid.
    void pass()
    {
        if (!is_wanted_.load(std::memory_order_relaxed)) return;
        leave();
        enter();
    }
    /// Returns the number of flushes so far. A worker that is inside sees the same value until its next safe point.
    std::uint64_t flushes() const noexcept { return flushes_; }
    /// Waits until no worker is inside and calls drop(), unless another worker has done so since flushes() was `seen`.
    /// The caller is inside before and after; the call is a safe point.
    template <class Drop>
    void flush(std::uint64_t seen, Drop&& drop)
    {
        leave();
        {
            const std::lock_guard turn(turn_);
            if (flushes_ == seen) {
                is_wanted_.store(true, std::memory_order_relaxed);
                const std::lock_guard alone(inside_);
                drop();
                ++flushes_;
                is_wanted_.store(false, std::memory_order_relaxed);
            }
        }
        enter();
    }

private:
    // Takes the turn first, so that a worker that waits to flush keeps others from entering.
    void enter()
    {
        const std::lock_guard turn(turn_);
        inside_.lock_shared();
    }
    void leave() { inside_.unlock_shared(); }

    std::mutex turn_;  ///< held by a worker that enters or flushes
    std::shared_mutex inside_;
    std::atomic<bool> is_wanted_ = false;
    std::uint64_t flushes_ = 0;  ///< written while no worker is inside
};

}  // namespace occam::accel
