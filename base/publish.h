// What one thread makes and others read meanwhile: published by one store, read by one load. On x86 both are plain moves, so
// that who has it alone pays nothing.
#pragma once

#include <atomic>
#include <mutex>

namespace occam {

/// Whoever reads the value by read_published() sees all that was written before.
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

/// Holds a mutex for a scope; or nothing, if there is none since nobody else is there.
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
