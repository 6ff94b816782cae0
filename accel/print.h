// Writes rays, hits and what they are made of to streams, for people who look for a fault (base/print.h).
//
// Space    Lengths are written as they are stored: frame lengths, or those of a cage's dicing frame.
#pragma once

#include <iosfwd>

#include "accel/igrid.h"
#include "accel/tracer.h"
#include "base/print.h"

namespace occam::lod {

std::ostream& operator<<(std::ostream& out, const Footprint& footprint);
std::ostream& operator<<(std::ostream& out, const PatchRef& patch);
std::ostream& operator<<(std::ostream& out, const TileRef& tile);

}  // namespace occam::lod

namespace occam::accel {

std::ostream& operator<<(std::ostream& out, const PairRange& pairs);
std::ostream& operator<<(std::ostream& out, const QuadRef& quad);
std::ostream& operator<<(std::ostream& out, const Slab& slab);
std::ostream& operator<<(std::ostream& out, const Ray& ray);
std::ostream& operator<<(std::ostream& out, const SurfaceHit& hit);
std::ostream& operator<<(std::ostream& out, const FirstHit& hit);
std::ostream& operator<<(std::ostream& out, const RayCost& cost);
std::ostream& operator<<(std::ostream& out, const TraceCounters& counters);

}  // namespace occam::accel
