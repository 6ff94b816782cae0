#include "render/lent_arena.h"

#include <mutex>
#include <utility>
#include <vector>

namespace occam::render {

struct LentArena::Idle {
    std::mutex mutex;
    std::vector<std::unique_ptr<Arena>> arenas;
    std::size_t lent = 0;  ///< arenas that will come back; there is room for them
};

LentArena::Idle& LentArena::idle()
{
    static Idle* const all = new Idle;  // never destroyed: threads may still render when the process ends
    return *all;
}

LentArena::LentArena(int threads)
{
    Idle& all = idle();
    const std::lock_guard lock(all.mutex);
    for (auto& arena : all.arenas) {
        if (arena->threads != threads) continue;
        std::swap(arena, all.arenas.back());
        arena_ = std::move(all.arenas.back());
        all.arenas.pop_back();
        ++all.lent;
        return;
    }
    all.arenas.reserve(all.arenas.size() + all.lent + 1);  // giving it back must not fail
    arena_ = std::make_unique<Arena>(threads);
    ++all.lent;
}

LentArena::~LentArena()
{
    Idle& all = idle();
    const std::lock_guard lock(all.mutex);
    --all.lent;
    all.arenas.push_back(std::move(arena_));
}

}  // namespace occam::render
