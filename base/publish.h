// Publishes data that one thread makes while others read it, by one store and one load. On x86 both are plain
// moves, so a thread that has the data to itself pays nothing.
#pragma once

#include <atomic>
#include <mutex>

namespace occam {

/// Publishes the value: a thread that reads it by read_published() sees all that was written before.
template <class T>
void publish(T& place, T value) noexcept
{
    std::atomic_ref<T>(place).store(value, std::memory_order_release);
}
template <class T>
T read_published(const T& place) noexcept
{
    return std::atomic_ref<T>(const_cast<T&>(place)).load(std::memory_order_acquire);
}

/// Locks the mutex for a scope if one is given. No mutex is given if no other thread uses the data.
class MaybeLock {
public:
    explicit MaybeLock(std::mutex* mutex) : mutex_(mutex)
    {
        if (mutex_) mutex_->lock();
    }
    ~MaybeLock()
    {
        if (mutex_) mutex_->unlock();
    }
    MaybeLock(const MaybeLock&) = delete;
    MaybeLock& operator=(const MaybeLock&) = delete;

private:
    std::mutex* mutex_;
};

}  // namespace occam
