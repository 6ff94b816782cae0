#include "io/open_temporaries.h"

#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstring>

namespace occam {

struct TemporaryPlace {
    enum class State : unsigned char { Free, Changing, Listed };
    std::atomic<State> state{State::Free};
    int descriptor = -1;
    char path[4096] = {};
};

namespace {

constinit TemporaryPlace temporary_places[16];
static_assert(std::atomic<TemporaryPlace::State>::is_always_lock_free);  // a signal handler may use no other atomics

}  // namespace

void ListedTemporary::list(const std::filesystem::path& file, int descriptor) noexcept
{
    using State = TemporaryPlace::State;
    const std::string& name = file.native();
    if (place_ || name.size() >= sizeof temporary_places->path) return;
    for (TemporaryPlace& place : temporary_places) {
        State free = State::Free;
        if (!place.state.compare_exchange_strong(free, State::Changing)) continue;
        place.descriptor = descriptor;
        std::memcpy(place.path, name.c_str(), name.size() + 1);
        place.state = State::Listed;
        place_ = &place;
        return;
    }
}

void ListedTemporary::unlist() noexcept
{
    if (place_) place_->state = TemporaryPlace::State::Free;
    place_ = nullptr;
}

void remove_open_temporaries() noexcept
{
    for (const TemporaryPlace& place : temporary_places)
        if (place.state == TemporaryPlace::State::Listed && is_same_file(place.descriptor, place.path)) unlink(place.path);
}

bool is_same_file(int descriptor, const char* name) noexcept
{
    struct stat open_file = {}, named = {};
    return fstat(descriptor, &open_file) == 0 && stat(name, &named) == 0 && open_file.st_dev == named.st_dev &&
           open_file.st_ino == named.st_ino;
}

}  // namespace occam
