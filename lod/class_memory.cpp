#include "lod/class_memory.h"

#include "base/error_without_file.h"

namespace occam::lod {

class ClassMemory::Pooled final : public LimitSource {
public:
    Pooled(ClassMemory& pool, Make make) : pool_(pool), make_(std::move(make)) {}
    ~Pooled() override
    {
        const std::lock_guard lock(pool_.mutex_);
        if (kept_) drop();
    }
    Pooled(const Pooled&) = delete;
    Pooled& operator=(const Pooled&) = delete;

    void evaluate(double u, double v, Of of, LimitStencil& out) const override { hold()->evaluate(u, v, of, out); }
    std::size_t bytes() const noexcept override { return sizeof(Pooled); }

private:
    using Kept = std::shared_ptr<const LimitSource>;

    Kept hold() const
    {
        if (Kept known = find()) return known;
        const std::lock_guard making(making_);
        if (Kept known = find()) return known;  // another thread was first
        Kept made = make_();
        const std::lock_guard lock(pool_.mutex_);
        pool_.order_.push_front(this);  // first, since it may throw
        place_ = pool_.order_.begin();
        kept_ = made;
        bytes_ = made->bytes();
        pool_.kept_bytes_ += bytes_;
        while (pool_.kept_bytes_ > pool_.pool_bytes_ && pool_.order_.back() != this) pool_.order_.back()->drop();
        return made;
    }
    Kept find() const
    {
        const std::lock_guard lock(pool_.mutex_);
        if (kept_) pool_.order_.splice(pool_.order_.begin(), pool_.order_, place_);
        return kept_;
    }
    // The lock of the pool is held. A thread that evaluates the source now keeps it for as long as it does so.
    void drop() const
    {
        pool_.order_.erase(place_);
        pool_.kept_bytes_ -= bytes_;
        kept_.reset();
    }

    ClassMemory& pool_;
    Make make_;
    mutable std::mutex making_;
    mutable Kept kept_;
    mutable std::size_t bytes_ = 0;  ///< of what is kept
    mutable std::list<const Pooled*>::iterator place_;
};

void ClassMemory::check_room() const
{
    if (bytes_ <= most_bytes_) return;
    throw error_without_file(
        "the patches of the subdivision cages are connected and creased in so many ways that their tables "
        "would take more than " +
            std::to_string(most_bytes_ >> 20) + " MB",
        "--subdivide off renders the polygons themselves");
}

std::unique_ptr<const LimitSource> ClassMemory::pooled(Make make)
{
    return std::make_unique<Pooled>(*this, std::move(make));
}

std::size_t ClassMemory::kept() const
{
    const std::lock_guard lock(mutex_);
    return order_.size();
}

}  // namespace occam::lod
