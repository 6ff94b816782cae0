// Lets one of several workers drop what all of them use. Each is inside while it works; at its safe points it steps out if
// asked to.
//
// Threads  any.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <shared_mutex>

namespace occam::accel {

class FlushGate {
public:
    /// Inside for a scope. Of no gate: nobody else is there.
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

    /// A safe point of somebody inside: what is behind the gate may be another's work afterwards, and empty.
    void pass()
    {
        if (!is_wanted_.load(std::memory_order_relaxed)) return;
        leave();
        enter();
    }
    /// Flushes so far; of use inside, and until the next safe point.
    std::uint64_t flushes() const noexcept { return flushes_; }
    /// For somebody inside, as a safe point: calls drop() with nobody inside, unless another has flushed since `seen`.
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
    // Through the turn: whoever wants to flush keeps others from coming in before it.
    void enter()
    {
        const std::lock_guard turn(turn_);
        inside_.lock_shared();
    }
    void leave() { inside_.unlock_shared(); }

    std::mutex turn_;  ///< of those who come in or flush
    std::shared_mutex inside_;
    std::atomic<bool> is_wanted_ = false;
    std::uint64_t flushes_ = 0;  ///< written with nobody inside
};

}  // namespace occam::accel
