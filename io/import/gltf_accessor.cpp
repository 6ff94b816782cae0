#include "io/import/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <type_traits>

namespace occam::import {

namespace {

constexpr std::size_t kSpareBytes = std::size_t(512) << 20;
constexpr std::size_t kExpansion = 16;
constexpr int kMostComponents = 16;

std::string name_of(int accessor) { return "accessors[" + std::to_string(accessor) + "]"; }

int component_bytes(int type)
{
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

// Normalised integers are converted as in glTF 2.0, sec. 3.11.
template <class Out, class In>
Out convert(In x, bool normalized)
{
    if constexpr (std::is_floating_point_v<Out> && std::is_integral_v<In>) {
        constexpr Out kMax = static_cast<Out>(std::numeric_limits<In>::max());
        if (normalized) return std::max(static_cast<Out>(x) / kMax, Out(-1));
    }
    return static_cast<Out>(x);
}

// Describes elements of an accessor, at most one in each `stride` bytes; data is null if all of them are zero.
struct Elements {
    const unsigned char* data = nullptr;
    std::size_t stride = 0, count = 0;
    int components = 0, component_type = 0;
};

template <class In, class Out>
void copy(const Elements& from, bool normalized, int width, Out* out)
{
    const bool is_packed = from.components == width && from.stride == static_cast<std::size_t>(width) * sizeof(In);
    if (std::is_same_v<In, Out> && is_packed) {
        if (from.count > 0) std::memcpy(out, from.data, from.count * from.stride);  // the data has this layout already
        return;
    }
    const unsigned char* data = from.data;
    for (std::size_t i = 0; i < from.count; ++i, data += from.stride, out += width)
        for (int c = 0; c < from.components; ++c) {
            In x;
            std::memcpy(&x, data + static_cast<std::size_t>(c) * sizeof(In), sizeof(In));
            out[c] = convert<Out>(x, normalized);
        }
}

template <class Out>
void copy_any(const Elements& from, bool normalized, int width, Out* out)
{
    const auto as = [&]<class In>(In) { copy<In>(from, normalized, width, out); };
    switch (from.component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return as(std::int8_t());
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return as(std::uint8_t());
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return as(std::int16_t());
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return as(std::uint16_t());
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return as(std::uint32_t());
        default:
            if constexpr (std::is_floating_point_v<Out>) return as(float());
    }
}

// Finds the least and greatest value of each component. It takes eight elements at a time, so that the inner loop runs over
// whole registers.
struct Extremes {
    static constexpr std::size_t kAtOnce = 8, kMaxComponents = kMostComponents;

    explicit Extremes(std::size_t components) : low(components, kInf), high(components, -kInf) {}

    void add(std::span<const float> values)
    {
        const std::size_t n = low.size(), block = n * kAtOnce, whole = values.size() / block * block;
        if (whole > 0) {
            float least[kAtOnce * kMaxComponents], most[kAtOnce * kMaxComponents], sum[kAtOnce * kMaxComponents] = {};
            std::fill_n(least, block, kInf);
            std::fill_n(most, block, -kInf);
            for (std::size_t v = 0; v < whole; v += block)
                for (std::size_t k = 0; k < block; ++k) {
                    const float x = values[v + k];
                    least[k] = x < least[k] ? x : least[k];
                    most[k] = x > most[k] ? x : most[k];
                    sum[k] += x * 0.0f;  // the sum is NaN from then on if x is not finite
                }
            for (std::size_t k = 0; k < block; ++k) {
                low[k % n] = std::min(low[k % n], least[k]);
                high[k % n] = std::max(high[k % n], most[k]);
                is_finite &= sum[k] == 0;
            }
        }
        for (std::size_t v = whole; v < values.size(); ++v) {
            low[v % n] = std::min(low[v % n], values[v]);
            high[v % n] = std::max(high[v % n], values[v]);
            is_finite &= std::abs(values[v]) < kInf;
        }
    }

    static constexpr float kInf = std::numeric_limits<float>::infinity();
    std::vector<float> low, high;
    bool is_finite = true;
};

}  // namespace

struct AccessorReader::Layout : Elements {};

AccessorReader::AccessorReader(const tinygltf::Model& model, const Report& report)
    : model_(model), report_(report), expansion_bytes_(most_bytes()), copies_(report)
{
    for (const tinygltf::Buffer& buffer : model_.buffers) copies_.allow_copies_of(buffer.data.size());
}

std::size_t AccessorReader::most_bytes() const
{
    std::size_t bytes = kSpareBytes;
    for (const tinygltf::Buffer& buffer : model_.buffers) bytes += kExpansion * buffer.data.size();
    return bytes;
}

void AccessorReader::refuse(int accessor, const std::string& what) const
{
    throw Error(report_.name(), what, name_of(accessor));
}

const tinygltf::Accessor& AccessorReader::at(int accessor) const
{
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= model_.accessors.size())
        refuse(accessor, "there is no such accessor");
    return model_.accessors[static_cast<std::size_t>(accessor)];
}

int AccessorReader::components(int accessor) const
{
    const int n = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(at(accessor).type));
    if (n <= 0) refuse(accessor, "has no type");
    return n;
}

std::span<const unsigned char> AccessorReader::view(int buffer_view, const std::string& where) const
{
    if (buffer_view < 0 || static_cast<std::size_t>(buffer_view) >= model_.bufferViews.size())
        throw Error(report_.name(), "there is no such buffer view", where);
    const tinygltf::BufferView& v = model_.bufferViews[static_cast<std::size_t>(buffer_view)];
    if (v.buffer < 0 || static_cast<std::size_t>(v.buffer) >= model_.buffers.size())
        throw Error(report_.name(), "there is no such buffer", where);
    const std::vector<unsigned char>& bytes = model_.buffers[static_cast<std::size_t>(v.buffer)].data;
    if (v.byteOffset > bytes.size() || v.byteLength > bytes.size() - v.byteOffset)
        throw Error(report_.name(), "the buffer view does not fit its buffer", where);
    return std::span(bytes).subspan(v.byteOffset, v.byteLength);
}

void AccessorReader::charge(std::size_t bytes, int accessor)
{
    if (bytes > expansion_bytes_) refuse(accessor, "accessors expand to far more than the buffers hold");
    expansion_bytes_ -= bytes;
}

AccessorReader::Layout AccessorReader::locate(int accessor, int width) const
{
    const tinygltf::Accessor& a = at(accessor);
    const int n = components(accessor), element_bytes = n * component_bytes(a.componentType);
    if (element_bytes <= 0) refuse(accessor, "has no component type");
    if (n > width)
        refuse(accessor, "has " + std::to_string(n) + " components where " + std::to_string(width) + " are wanted");
    if (a.count > std::numeric_limits<std::uint32_t>::max()) refuse(accessor, "counts more than 2^32 elements");
    Layout layout{{nullptr, static_cast<std::size_t>(element_bytes), a.count, n, a.componentType}};
    if (a.bufferView < 0) return layout;

    const auto bytes = view(a.bufferView, name_of(accessor));
    const std::size_t declared = model_.bufferViews[static_cast<std::size_t>(a.bufferView)].byteStride;
    if (declared != 0) layout.stride = declared;
    if (layout.stride < static_cast<std::size_t>(element_bytes))
        refuse(accessor, "elements overlap: the stride is too small");
    // The product cannot overflow: count is below 2^32, and validation has refused a stride above 252.
    const std::size_t needed = a.count == 0 ? 0 : (a.count - 1) * layout.stride + static_cast<std::size_t>(element_bytes);
    if (a.byteOffset > bytes.size() || needed > bytes.size() - a.byteOffset)
        refuse(accessor, "does not fit its buffer view");
    layout.data = bytes.data() + a.byteOffset;
    return layout;
}

template <class Out>
void AccessorReader::fill(const Layout& layout, int accessor, int width, Out* out, const ChosenElements& chosen,
                          bool normalized)
{
    const tinygltf::Accessor& a = at(accessor);
    const std::size_t floats = static_cast<std::size_t>(width), wanted = chosen ? chosen->size() : layout.count;
    for (std::size_t i = 0; layout.data && i < wanted;) {
        Elements run = layout;  // of elements that follow each other
        if (chosen) {
            const std::uint32_t* const first = &(*chosen)[i];
            run.data += *first * layout.stride;
            for (run.count = 1; i + run.count < wanted && first[run.count] == *first + run.count;) ++run.count;
        }
        copy_any(run, normalized, width, out + i * floats);
        i += run.count;
    }
    if (!a.sparse.isSparse) return;
    Layout value = layout;
    std::size_t i = 0;
    for (const std::uint32_t place : sparse_places(accessor, value)) {
        if (!chosen) i = place;
        while (chosen && i < wanted && (*chosen)[i] < place) ++i;
        if (i < wanted && (!chosen || (*chosen)[i] == place)) copy_any(value, normalized, width, out + i * floats);
        value.data += value.stride;
    }
}

// Returns the elements that the sparse part of an accessor replaces, and makes `value` describe what replaces the first.
std::vector<std::uint32_t> AccessorReader::sparse_places(int accessor, Layout& value)
{
    const tinygltf::Accessor& a = at(accessor);
    const std::size_t count = static_cast<std::size_t>(std::max(a.sparse.count, 0));
    const auto index_bytes = view(a.sparse.indices.bufferView, name_of(accessor) + ".sparse.indices");
    const auto value_bytes = view(a.sparse.values.bufferView, name_of(accessor) + ".sparse.values");
    const std::size_t index_size = static_cast<std::size_t>(component_bytes(a.sparse.indices.componentType));
    const std::size_t value_size = static_cast<std::size_t>(value.components * component_bytes(a.componentType));
    const auto fits = [&](std::span<const unsigned char> bytes, int offset, std::size_t size) {
        return offset >= 0 && static_cast<std::size_t>(offset) <= bytes.size() &&
               count * size <= bytes.size() - static_cast<std::size_t>(offset);
    };
    if (index_size == 0 || count > a.count || !fits(index_bytes, a.sparse.indices.byteOffset, index_size) ||
        !fits(value_bytes, a.sparse.values.byteOffset, value_size))
        refuse(accessor, "its sparse part does not fit");
    charge(count * sizeof(std::uint32_t), accessor);  // many may read the same part
    std::vector<std::uint32_t> where(count);
    const Elements indices{index_bytes.data() + a.sparse.indices.byteOffset, index_size, count, 1,
                           a.sparse.indices.componentType};
    copy_any(indices, false, 1, where.data());
    for (std::size_t i = 0; i < count; ++i)
        if (where[i] >= a.count || (i > 0 && where[i] <= where[i - 1]))
            refuse(accessor, "sparse indices must rise and stay in range");
    value.data = value_bytes.data() + a.sparse.values.byteOffset;
    value.stride = value_size, value.count = 1;
    return where;
}

// Reads the raw numbers of an accessor, some thousand at a time; those of a sparse accessor are read at once.
template <class Visit>
void AccessorReader::for_each_part(const Layout& layout, int accessor, Visit&& visit)
{
    constexpr std::size_t kElements = 4096;
    const std::size_t n = static_cast<std::size_t>(layout.components),
                      step = at(accessor).sparse.isSparse ? layout.count : kElements;
    std::vector<float> values;
    for (std::size_t begin = 0; begin < layout.count; begin += step) {
        Layout part = layout;
        part.count = std::min(step, layout.count - begin);
        if (part.data) part.data += begin * layout.stride;
        values.assign(part.count * n, 0.0f);
        fill(part, accessor, layout.components, values.data(), {}, false);
        visit(std::span<const float>(values));
    }
}

void AccessorReader::check_values(Report& report)
{
    expansion_bytes_ = most_bytes();  // nothing of this is kept, but it takes time
    for (int i = 0; i < static_cast<int>(model_.accessors.size()); ++i) {
        const tinygltf::Accessor& a = at(i);
        const std::size_t n = static_cast<std::size_t>(components(i));
        // Padded columns of small matrices are not read here, and bounds of 32-bit indices are of no use.
        if (n > 4 && a.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) continue;
        if (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) continue;
        const Layout layout = locate(i, static_cast<int>(n));
        charge(layout.count * n * sizeof(float), i);
        Extremes extremes(n);
        for_each_part(layout, i, [&](std::span<const float> values) { extremes.add(values); });
        if (!extremes.is_finite) report.warn("accessor holds a number that is not finite", name_of(i));
        const auto differs = [&](const std::vector<double>& declared, std::span<const float> found) {
            if (declared.size() != n) return false;
            for (std::size_t c = 0; c < n; ++c)
                if (static_cast<float>(declared[c]) != found[c]) return true;
            return false;
        };
        if (differs(a.minValues, extremes.low) || differs(a.maxValues, extremes.high))
            report.warn("min or max is not that of the values", name_of(i));
    }
}

template <class Value, class Out>
std::vector<Value> AccessorReader::read(int accessor, int width, const ChosenElements& chosen)
{
    const Layout layout = locate(accessor, width);
    const std::size_t values = (chosen ? chosen->size() : layout.count) * static_cast<std::size_t>(width);
    charge(values * sizeof(float), accessor);
    std::vector<Value> out(values / (sizeof(Value) / sizeof(Out)), Value(0));
    fill(layout, accessor, width, reinterpret_cast<Out*>(out.data()), chosen, at(accessor).normalized);
    return out;
}

std::vector<float> AccessorReader::floats(int accessor, int width) { return read<float, float>(accessor, width, {}); }
std::vector<Vec2f> AccessorReader::vec2(int accessor, const ChosenElements& chosen)
{
    return read<Vec2f, float>(accessor, 2, chosen);
}
std::vector<Vec3f> AccessorReader::vec3(int accessor, const ChosenElements& chosen)
{
    return read<Vec3f, float>(accessor, 3, chosen);
}
std::vector<Vec4f> AccessorReader::vec4(int accessor, const ChosenElements& chosen)
{
    return read<Vec4f, float>(accessor, 4, chosen);
}
std::vector<std::uint32_t> AccessorReader::indices(int accessor)
{
    const int type = at(accessor).componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        refuse(accessor, "indices must be unsigned integers");
    return read<std::uint32_t, std::uint32_t>(accessor, 1, {});
}
std::vector<glm::u16vec4> AccessorReader::joints(int accessor, const ChosenElements& chosen)
{
    const int type = at(accessor).componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
        refuse(accessor, "joints must be unsigned integers of 8 or 16 bits");
    return read<glm::u16vec4, std::uint16_t>(accessor, 4, chosen);
}
std::vector<std::uint32_t> AccessorReader::numbers(int accessor)
{
    const std::size_t count = locate(accessor, kMostComponents).count;
    charge(count * sizeof(std::uint32_t), accessor);
    std::vector<std::uint32_t> list(count);
    std::iota(list.begin(), list.end(), 0u);
    return list;
}

}  // namespace occam::import
