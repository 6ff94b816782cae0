// Runs parts of some work in several threads, which are kept for later.
//
// No library does this here: oneTBB 2021.8 ends the process where the system refuses a thread, keeps memory of every arena,
// and waits for ever where there was no memory while it counted the processors.
//
// Threads  any; several may run work at once.
#pragma once

#include <functional>

namespace occam {

/// Calls work(0), work(1), and so on up to work(count - 1), each once, in up to `count` threads at once, of which the
/// caller's is one. Returns when all have ended. Threads that the system refuses are done without, and the others make their
/// parts, so no part may wait for another. Each part computes with DefaultFloats.
///
/// Throws what a part threw first. Parts that have not begun by then are left out.
void run_in_threads(int count, const std::function<void(int)>& work);

}  // namespace occam
