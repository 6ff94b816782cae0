#include "base/threads.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>

#include "base/default_floats.h"

namespace occam {
namespace {

// Holds work that is being done. It lives in the caller's run_in_threads().
struct Work {
    const std::function<void(int)>& call;
    int count;
    int begun = 0, running = 0;
    std::exception_ptr error{};
    std::condition_variable ended{};
    Work* next = nullptr;  // in the pool's list
};

// The kept threads. Each of them takes parts of any work in the list.
class Pool {
public:
    void run(Work& work)
    {
        std::unique_lock lock(mutex_);
        work.next = first_;
        first_ = &work;
        wanted_ += work.count - 1;
        start_threads();
        awake_.notify_all();
        while (work.begun < work.count) run_part(work, lock);
        work.ended.wait(lock, [&] { return work.running == 0; });
        wanted_ -= work.count - 1;
        Work** place = &first_;
        while (*place != &work) place = &(*place)->next;
        *place = work.next;
    }

private:
    void start_threads() noexcept
    {
        try {
            for (; threads_ < wanted_; ++threads_) std::thread([this] { serve(); }).detach();
        } catch (const std::system_error&) {
        } catch (const std::bad_alloc&) {
        }
    }
    [[noreturn]] void serve()
    {
        std::unique_lock lock(mutex_);
        for (;;) {
            Work* work = first_;
            while (work && work->begun == work->count) work = work->next;
            if (work) run_part(*work, lock);
            else awake_.wait(lock);
        }
    }
    // Runs the next part of the work. The lock is given back meanwhile.
    static void run_part(Work& work, std::unique_lock<std::mutex>& lock)
    {
        const int part = work.begun++;
        ++work.running;
        lock.unlock();
        std::exception_ptr error;
        try {
            const DefaultFloats floats;
            work.call(part);
        } catch (...) {
            error = std::current_exception();
        }
        lock.lock();
        if (error && !work.error) work.error = error;
        if (error) work.begun = work.count;
        if (--work.running == 0) work.ended.notify_one();
    }

    std::mutex mutex_;
    std::condition_variable awake_;
    Work* first_ = nullptr;
    int wanted_ = 0;   // threads that all work together could use, besides its callers
    int threads_ = 0;  // that were started
};

}  // namespace

void run_in_threads(int count, const std::function<void(int)>& call)
{
    if (count <= 0) return;
    static Pool* const pool = new Pool;  // never destroyed: its threads wait until the process ends
    Work work{call, count};
    pool->run(work);
    if (work.error) std::rethrow_exception(work.error);
}

}  // namespace occam
