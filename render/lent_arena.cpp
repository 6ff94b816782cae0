#include "render/lent_arena.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace occam::render {
namespace {

// TBB counts the processors when their number is first needed. If an allocation fails in that, every later call waits for
// ever for the count to end. So they are counted while this library is loaded.
const int kProcessors = tbb::info::default_concurrency();

}  // namespace

struct LentArena::All {
    std::mutex mutex;
    std::vector<std::unique_ptr<Arena>> idle;
    std::size_t lent = 0;  ///< arenas that will come back; there is room for them
    int allowed = kProcessors;
    std::unique_ptr<tbb::global_control> control;  ///< null until more threads are asked for than there are processors

    void allow(int threads)
    {
        if (threads <= allowed) return;
        // The old one goes afterwards, so that frames that are being made keep their threads.
        control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                        static_cast<std::size_t>(threads));
        allowed = threads;
    }
};

LentArena::All& LentArena::all_arenas()
{
    static All* const all = new All;  // never destroyed: threads may still render when the process ends
    return *all;
}

LentArena::LentArena(int threads)
{
    All& all = all_arenas();
    const std::lock_guard lock(all.mutex);
    all.allow(threads);
    for (auto& arena : all.idle) {
        if (arena->threads != threads) continue;
        std::swap(arena, all.idle.back());
        arena_ = std::move(all.idle.back());
        all.idle.pop_back();
        ++all.lent;
        return;
    }
    all.idle.reserve(all.idle.size() + all.lent + 1);  // giving it back must not fail
    arena_ = std::make_unique<Arena>(threads);
    ++all.lent;
}

LentArena::~LentArena()
{
    All& all = all_arenas();
    const std::lock_guard lock(all.mutex);
    --all.lent;
    all.idle.push_back(std::move(arena_));
}

}  // namespace occam::render
