// How far a frame is, said in the way that was asked for.
#pragma once

#include <chrono>
#include <string>

#include "arguments.h"

namespace occam::command {

class ProgressDisplay {
public:
    /// Auto is a bar if standard error is a terminal, else nothing.
    ProgressDisplay(ProgressStyle style, bool quiet);
    ~ProgressDisplay();
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;

    void say(const std::string& status);  ///< what begins now: reading, writing
    void show(const Progress& progress);
    /// Clears the bar, so that other lines can follow.
    void end();

private:
    enum class Style : unsigned char { None, Bar, Plain, OpenJd };
    void draw(const std::string& line);

    Style style_;
    bool is_bar_drawn_ = false;
    int last_percent_ = -1;
};

/// "4 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace occam::command
