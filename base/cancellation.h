// The request to stop, as loops that may run for long see it.
//
// A thread that works for a frame opens a CancelScope with the frame's control. Loops whose length depends on the input call
// throw_if_cancelled(), which throws Cancelled once the frame is to stop. The control belongs to the thread and is no
// parameter, because it says nothing about what the loops compute, and all rooms lie between the frame and its loops. What
// is half made when Cancelled is thrown is dropped with the frame; what outlives the frame is published only when it is
// whole.
//
// Threads  Each thread has its own control; any thread, and a signal handler, may ask it to stop.
#pragma once

namespace occam {

/// The request to stop has been seen. It is no error: the frame ends with what is done.
struct Cancelled {};

/// Lets a control stop the current thread, for a scope. Control has is_cancelled().
class CancelScope {
public:
    template <class Control>
    explicit CancelScope(const Control& control) noexcept : outer_(current_)
    {
        current_ = {&control, [](const void* of) noexcept { return static_cast<const Control*>(of)->is_cancelled(); }};
    }
    ~CancelScope() { current_ = outer_; }
    CancelScope(const CancelScope&) = delete;
    CancelScope& operator=(const CancelScope&) = delete;

    /// Returns whether the thread is asked to stop; a thread without a control never is.
    static bool is_cancelled() noexcept { return current_.control && current_.asks(current_.control); }

private:
    struct Question {
        const void* control;
        bool (*asks)(const void*) noexcept;
    };
    static inline constinit thread_local Question current_{nullptr, nullptr};
    Question outer_;
};

/// Throws Cancelled if the thread is asked to stop.
inline void throw_if_cancelled()
{
    if (CancelScope::is_cancelled()) throw Cancelled();
}

}  // namespace occam
