// Finds options that have no effect together with the others that were given.
#pragma once

#include <set>
#include <string>

#include "arguments.h"

namespace occam::command {

/// Throws std::invalid_argument that names the first option without an effect, and why it has none.
/// given   names of the options that were on the command line: "--aov"
void refuse_idle(const RenderArguments& arguments, const std::set<std::string>& given);
/// The same for `occam compare`.
void refuse_idle(const CompareArguments& arguments, const std::set<std::string>& given);
/// The same for a command that makes no picture.
void refuse_idle(const SceneArguments& arguments, const std::set<std::string>& given);

}  // namespace occam::command
