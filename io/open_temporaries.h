// The temporary files that this process has open, for a signal handler that ends the process and tidies up first.
//
// Threads  any number may list files. The handler waits for none of them and allocates nothing: a file that is being listed
//          at that moment stays, and so does one beyond the 16th or with a path of more than 4,095 bytes.
#pragma once

#include <filesystem>

namespace occam {

struct TemporaryPlace;

/// Lists one open file until unlist() or its own end.
class ListedTemporary {
public:
    ListedTemporary() = default;
    ~ListedTemporary() { unlist(); }
    ListedTemporary(const ListedTemporary&) = delete;
    ListedTemporary& operator=(const ListedTemporary&) = delete;

    void list(const std::filesystem::path& file, int descriptor) noexcept;
    /// Takes the file off the list, which has to be done before its descriptor is closed.
    void unlist() noexcept;

private:
    TemporaryPlace* place_ = nullptr;
};

/// Removes the listed files whose names still lead to them. May be called by a signal handler.
void remove_open_temporaries() noexcept;

/// Returns true if the name leads to the file that is open. May be called by a signal handler.
bool is_same_file(int descriptor, const char* name) noexcept;

}  // namespace occam
