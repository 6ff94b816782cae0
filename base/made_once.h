// Holds what is made once, by whoever asks first.
//
// No exception leaves a std::call_once in this project: in glibc 2.36 one passes a C function, pthread_once(), whose cleanup
// loads a library when that happens for the first time. Where there is no memory for that, the process ends.
//
// Threads  any.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

namespace occam {

/// T   may be incomplete where neither is anything made nor the holder destroyed
template <class T>
class MadeOnce {
public:
    MadeOnce() = default;
    ~MadeOnce() { delete made_.load(std::memory_order_relaxed); }
    MadeOnce(const MadeOnce&) = delete;
    MadeOnce& operator=(const MadeOnce&) = delete;

    /// Returns what was made, or null if nothing is made yet.
    const T* get() const noexcept { return made_.load(std::memory_order_acquire); }

    /// Returns what make() has returned as a std::unique_ptr when it was called first; others that ask meanwhile wait. If
    /// make() throws, nothing is made, and the next one who asks calls it anew. It may not ask for the same thing itself.
    template <class Make>
    const T& get_or_make(Make&& make)
    {
        if (const T* made = get()) return *made;
        const std::lock_guard lock(mutex_);
        if (const T* made = made_.load(std::memory_order_relaxed)) return *made;
        std::unique_ptr<const T> made = std::forward<Make>(make)();
        made_.store(made.get(), std::memory_order_release);
        return *made.release();
    }

private:
    std::mutex mutex_;
    std::atomic<const T*> made_ = nullptr;
};

}  // namespace occam
