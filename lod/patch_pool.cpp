#include "lod/patch_pool.h"

namespace occam::lod {
namespace {

// Returns the entry's patch; if the entry holds another one, it is set first, by set(patch).
template <class Entry, class Set>
PosedPatch& filled(Entry& entry, bool is_known, const PosedCage& cage, PatchRef patch, Set&& set)
{
    if (!is_known) {
        entry.cage = nullptr;  // set() may be cancelled
        set(entry.value);
        entry.cage = &cage;
        entry.key = patch;
    }
    return entry.value;
}

}  // namespace

void PatchPool::forget() noexcept
{
    posed_.forget();
    if (displaced_uv_) displaced_uv_->forget();
    uv_.cage = rest_.cage = nullptr;
}

PosedPatch& PatchPool::posed(const PosedCage& cage, PatchRef patch)
{
    Table::Entry& entry = posed_.entry(cage, patch.face + 61 * patch.sub);
    return filled(entry, entry.holds(cage, patch), cage, patch, [&](PosedPatch& to) { to.set(cage, patch); });
}

PosedPatch& PatchPool::uv(const PosedCage& cage, PatchRef patch, int set)
{
    const bool is_known = uv_.holds(cage, patch) && uv_set_ == set;
    uv_set_ = set;
    return filled(uv_, is_known, cage, patch, [&](PosedPatch& to) { to.set_uv(cage, patch, set); });
}

PosedPatch& PatchPool::displaced_uv(const PosedCage& cage, PatchRef patch)
{
    if (!displaced_uv_) displaced_uv_ = std::make_unique<Table>();
    Table::Entry& entry = displaced_uv_->entry(cage, patch.face + 61 * patch.sub);
    return filled(entry, entry.holds(cage, patch), cage, patch,
                  [&](PosedPatch& to) { to.set_uv(cage, patch, cage.displacement.uv_set()); });
}

PosedPatch& PatchPool::rest(const PosedCage& cage, PatchRef patch)
{
    return filled(rest_, rest_.holds(cage, patch), cage, patch, [&](PosedPatch& to) {
        PosedCage rest;
        rest.slot = cage.slot;
        rest.topology = cage.topology;
        rest.keep();
        rest.derived = cage.rest_derived;
        to.set(rest, patch);
    });
}

}  // namespace occam::lod
