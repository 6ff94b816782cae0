#include "progress.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "base/printable.h"

namespace occam::command {
namespace {

constexpr int kBarWidth = 32;

// Prints text. A reader that takes none holds up the command, as he may, but not once a signal was noted: what he does not
// take is then left out, since there may be a picture to write. A reader who has gone away misses the text, which is no
// error of the stream: standard output is complete without it.
void put(std::FILE* to, const std::string& text)
{
    constexpr int kPatienceMs = 20;
    pollfd reader = {fileno(to), POLLOUT, 0};
    for (int ready = 0; ready == 0;) {
        ready = poll(&reader, 1, kPatienceMs);
        if (ready < 0 && errno == EINTR) ready = 0;
        if (ready == 0 && is_interrupted()) return;
    }
    const bool is_put = std::fputs(text.c_str(), to) >= 0 && std::fflush(to) == 0;
    if (!is_put && errno == EPIPE) std::clearerr(to);
}

// Returns true if the terminal moves its cursor when it is told to. One that is named `dumb` does not.
bool shows_bars()
{
    const char* name = std::getenv("TERM");
    return name && *name && std::string_view(name) != "dumb";
}

// Returns as much of the line as fits in one row of the terminal: one that went on in the next row could not be cleared.
std::string fitted(const std::string& line)
{
    winsize size = {};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return line;
    int columns = 0;
    for (std::size_t at = 0; at < line.size(); ++at) {
        const auto byte = static_cast<unsigned char>(line[at]);
        const bool continues = (byte & 0xc0) == 0x80;           // within a character of UTF-8
        columns += continues ? 0 : byte < 0x80 ? 1 : 2;         // characters beyond ASCII may be wide
        if (columns >= size.ws_col) return line.substr(0, at);  // the last column stays free
    }
    return line;
}

std::string sentence(const Progress& p)
{
    switch (p.stage) {
        case Stage::Waiting:
        case Stage::Preparing:
            return "preparing";
        case Stage::Done:
            return "done";
        case Stage::Rendering:
            break;
    }
    std::string text = "rendering, " + std::to_string(static_cast<int>(p.fraction * 100)) + " %";
    if (p.seconds_left >= 0) text += ", " + duration_text(p.seconds_left) + " left";
    return text;
}

}  // namespace

std::string duration_text(double seconds)
{
    const long s = std::lround(std::clamp(seconds, 0.0, 1e9));
    if (s < 60) return std::to_string(s) + " s";
    if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
    return std::to_string(s / 3600) + " h " + std::to_string(s % 3600 / 60) + " min";
}

ProgressDisplay::ProgressDisplay(ProgressStyle style, bool quiet) : style_(Style::None), is_quiet_(quiet)
{
    if (quiet) return;
    if (style == ProgressStyle::Auto && isatty(STDERR_FILENO)) style_ = shows_bars() ? Style::Bar : Style::Plain;
    if (style == ProgressStyle::Plain) style_ = Style::Plain;
    if (style == ProgressStyle::OpenJd) style_ = Style::OpenJd;
}

ProgressDisplay::~ProgressDisplay() { end(); }

void ProgressDisplay::draw(const std::string& line)
{
    put(stderr, "\r\033[K" + fitted(line));
    is_bar_drawn_ = true;
}

void ProgressDisplay::say(const std::string& status)
{
    const std::string line = printable_line(status);  // it may name a file
    if (style_ == Style::Bar) draw(line);
    if (style_ == Style::Plain) put(stderr, line + "\n");
    if (style_ == Style::OpenJd) put(stdout, "openjd_status: " + line + "\n");
}

void ProgressDisplay::announce(const std::string& what)
{
    if (is_quiet_) return;
    end();
    if (style_ == Style::OpenJd) say(what);
    else put(stderr, "occam: " + what + "\n");
}

void ProgressDisplay::finish_part(std::size_t done, std::size_t all, const std::string& file)
{
    const std::string line = printable_line(subject_ + ": " + file);
    if (style_ == Style::Plain) put(stderr, line + "\n");
    if (style_ == Style::OpenJd) put_percent(static_cast<int>(100 * done / all), line);
}

void ProgressDisplay::put_percent(int percent, const std::string& status)
{
    last_percent_ = percent;
    put(stdout, "openjd_progress: " + std::to_string(percent) + "\nopenjd_status: " + status + "\n");
}

void ProgressDisplay::fail(const std::string& what)
{
    end();
    if (style_ != Style::OpenJd) return;
    put(stdout, "openjd_fail: " + printable_line(what) + "\n");
}

void ProgressDisplay::show(const Progress& p)
{
    const std::string text = (subject_.empty() ? "" : subject_ + ", ") + sentence(p);
    const int percent = static_cast<int>(p.fraction * 100);
    if (style_ == Style::Bar) {
        const int full = static_cast<int>(p.fraction * kBarWidth);
        const std::string bar = std::string(std::size_t(full), '#') + std::string(std::size_t(kBarWidth - full), '.');
        draw("[" + bar + "] " + text);
    }
    // A line is printed only at each further 5 %, because a log is read by people.
    if (p.stage != Stage::Rendering || percent < last_percent_ + (last_percent_ < 0 ? 1 : 5)) return;
    last_percent_ = percent;
    if (style_ == Style::Plain) put(stderr, text + "\n");
    if (style_ == Style::OpenJd) put_percent(percent, text);
}

void ProgressDisplay::end()
{
    if (is_bar_drawn_) put(stderr, "\r\033[K");
    is_bar_drawn_ = false;
}

}  // namespace occam::command
