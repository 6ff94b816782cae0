// Builds igrids of patches: tiles of a patch, or all small patches of a cluster.
//
// Memory   scratch is reused from igrid to igrid; the results lie in the given arena.
// Threads  one at a time, as for the dicer.
#pragma once

#include <vector>

#include "accel/igrid.h"
#include "lod/dicer.h"

namespace occam::accel {

class LatticeBuilder {
public:
    explicit LatticeBuilder(lod::Dicer& dicer) noexcept : dicer_(dicer) {}

    struct PatchTile {
        lod::TileRef tile;
        lod::PatchRates coarser;  ///< the patch's rates at the pair's coarser level
    };

    /// The log2 of the largest number of quads with which a patch shares an igrid.
    static constexpr int kSmallExponent = 2;

    /// Builds an igrid of one tile, or of several patches of at most 2^kSmallExponent quads each.
    LatticeGrid* build(const GridSubject& of, std::span<const PatchTile> patches, Arena& arena);

    std::uint64_t micropolygons = 0;  ///< in all igrids so far

private:
    void clear();
    void add_vertices(const IGridPart& part, const lod::LevelGrid& vertices);
    void add_hanging(const IGridPart& part, std::uint32_t number, const lod::LevelGrid& vertices);
    void add_blocks(const IGridPart& part, std::uint32_t number, std::size_t first_hanging);
    template <class BoxAt>
    BoxTree box_tree(int leaves, Arena& arena, const BoxAt& box_at) const;
    LatticeGrid* finish(const GridSubject& of, Arena& arena);
    void keep_hanging(LatticeContents& contents, Arena& arena);
    Slab slab() const noexcept;
    Box3f box_of_block(const LatticeBlock& block, int key) const noexcept;
    void add_to(Box3f& box, std::uint32_t vertex, int key) const noexcept;

    lod::Dicer& dicer_;
    Arena diced_;
    // The igrid that is being built.
    int keys_ = 1;
    bool blends_ = false;
    std::size_t vertex_count_ = 0;            ///< at one key
    std::vector<float> fine_[3], coarse_[3];  ///< at each key, one after the other
    std::vector<IGridPart> parts_;
    std::vector<LatticeBlock> blocks_;
    std::vector<BlockHanging> block_hanging_;
    std::vector<lod::Hanging> hanging_;
    std::vector<std::uint32_t> hanging_quads_;
};

}  // namespace occam::accel
