// A limit to the copies that a scene has of what its file holds once: a small file may ask for very many of them.
#pragma once

#include "io/import/report.h"

namespace occam::import {

/// Counts the bytes of names, lists and meshes beyond the first copy of each.
class CopyBudget {
public:
    explicit CopyBudget(const Report& report) : report_(report) {}

    /// Takes so many copies from the budget. Throws Error, naming the element, if it has not enough left.
    void charge(std::size_t copies, std::size_t bytes, const std::string& where)
    {
        if (bytes > 0 && copies > left_ / bytes)
            throw Error(report_.name(), "the file asks for too many copies of what it holds once", where);
        left_ -= copies * bytes;
    }
    /// Lets the copies of what has so many bytes be several times as large as it is.
    void allow_copies_of(std::size_t bytes) { left_ += kExpansion * bytes; }

private:
    static constexpr std::size_t kExpansion = 16;
    const Report& report_;
    std::size_t left_ = std::size_t(512) << 20;
};

}  // namespace occam::import
