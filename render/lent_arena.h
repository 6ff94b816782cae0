// Lends an arena of threads to a frame.
//
// TBB (2021.8) keeps some 7 KB of every arena in which its threads have worked, even after the arena is destroyed. So none
// is destroyed, and frames that follow each other have the same one. For each number of threads there are as many as frames
// were ever made at once.
//
// An arena alone cannot have more threads than there are processors. Of several controls that allow more, TBB obeys the one
// that allows the fewest, and complains of arenas that ask for more. So the process has one control, which only grows.
//
// Threads  Any thread may borrow an arena; one frame at a time has it.
#pragma once

#include <tbb/task_arena.h>

#include <memory>

namespace occam::render {

class LentArena {
public:
    /// Throws std::bad_alloc.
    explicit LentArena(int threads);
    ~LentArena();
    LentArena(const LentArena&) = delete;
    LentArena& operator=(const LentArena&) = delete;

    /// Calls work() in the arena, and returns when it is done.
    template <class Work>
    void execute(const Work& work) const
    {
        arena_->arena.execute(work);
    }

private:
    struct Arena {
        explicit Arena(int count) : threads(count), arena(count) {}
        int threads;
        tbb::task_arena arena;
    };
    struct All;
    static All& all_arenas();

    std::unique_ptr<Arena> arena_;
};

}  // namespace occam::render
