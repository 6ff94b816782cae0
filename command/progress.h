// Display of a frame's progress, in the requested style. A reader who takes no lines holds up the command until a signal is
// noted; one who has gone away does not.
#pragma once

#include <chrono>
#include <exception>
#include <string>

#include "arguments.h"
#include "interrupt.h"

namespace occam::command {

class ProgressDisplay {
public:
    /// The style Auto is a bar if standard error is a terminal, lines if that terminal is a dumb one, and nothing otherwise.
    ProgressDisplay(ProgressStyle style, bool quiet);
    ~ProgressDisplay();
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;

    void say(const std::string& status);  ///< prints what begins now: reading, writing
    /// Prints a line in any style, unless the display is quiet.
    void announce(const std::string& what);
    void show(const Progress& progress);
    /// Sets the subject that stands before the progress where there are several frames.
    void set_subject(std::string subject) { subject_ = std::move(subject); }
    /// Reports that one of several equal parts is done and its file exists.
    void finish_part(std::size_t done, std::size_t all, const std::string& file);
    /// Prints the line from which a render farm learns what went wrong; does nothing in the other styles.
    void fail(const std::string& what);
    /// Clears the bar, so that other lines can follow.
    void end();

private:
    enum class Style : unsigned char { None, Bar, Plain, OpenJd };
    void draw(const std::string& line);
    void put_percent(int percent, const std::string& status);

    Style style_;
    bool is_quiet_;
    std::string subject_;
    bool is_bar_drawn_ = false;
    int last_percent_ = -1;
};

/// Does the work of a command, which may be interrupted, with a display of its progress. If it throws, the display says why.
/// What is made is in files, so it is made also when nobody reads the progress any more.
template <class Arguments>
int run_with_display(const Arguments& a, int (*work)(const Arguments&, ProgressDisplay&))
{
    if (!a.replay) outlive_readers();
    ProgressDisplay display(a.progress, a.quiet);
    try {
        return work(a, display);
    } catch (const std::exception& error) {
        display.fail(error.what());
        throw;
    }
}

/// Returns a duration as text: "4 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace occam::command
