// Ctrl-C and a polite kill: the first asks the command to end with what it has, the second ends it at once.
#pragma once

namespace occam::command {

void catch_interrupts() noexcept;
bool is_interrupted() noexcept;

}  // namespace occam::command
