// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The arrays in a glTF file: accessors, over views of its buffers.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "mesh/read/gltf_file.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// An accessor without a buffer is all zeros, so that the file's size does not bound it.
constexpr int64_t kMaxZeros = 65'536;

static_assert(std::endian::native == std::endian::little, "glTF is read as it lies in memory");

/// Component types of the format: their numbers, sizes and divisors.
struct ComponentType {
    int64_t number;
    size_t bytes;
    double most;  ///< 0 for floats
};
constexpr ComponentType kTypes[] = {{5120, 1, 127},   {5121, 1, 255},          {5122, 2, 32767},
                                    {5123, 2, 65535}, {5125, 4, 4294967295.0}, {5126, 4, 0}};

const ComponentType* find_type(int64_t number) {
    for (const ComponentType& type : kTypes) {
        if (type.number == number) return &type;
    }
    return nullptr;
}

double read_number(const char* raw, int64_t type) {
    const auto as = [&]<typename T>(T value) {
        std::memcpy(&value, raw, sizeof value);
        return static_cast<double>(value);
    };
    switch (type) {
        case 5120:
            return as(int8_t{});
        case 5121:
            return as(uint8_t{});
        case 5122:
            return as(int16_t{});
        case 5123:
            return as(uint16_t{});
        case 5125:
            return as(uint32_t{});
        default:
            return as(float{});
    }
}

}  // namespace

GltfFile::View GltfFile::view(int64_t index, int64_t offset, const JsonValue& asked_by) {
    const JsonValue* view = item("bufferViews", index, messages::kAnAccessor);
    if (view == nullptr) return {};
    const std::string* bytes = buffer(integer(*view, "buffer", 0));
    const int64_t start = integer(*view, "byteOffset", 0);
    const int64_t length = integer(*view, "byteLength", 0);
    const int64_t stride = integer(*view, "byteStride", 0, 252);
    if (!ok()) return {};
    const auto size = static_cast<int64_t>(bytes->size());
    if (start > size || length > size - start) {
        fail(*view, fmt::format(messages::kBufferViewTooLong, start + length, size));
        return {};
    }
    if (offset > length) {
        fail(asked_by, messages::kAccessorStartsPastEnd);
        return {};
    }
    return {std::string_view(*bytes).substr(static_cast<size_t>(start + offset),
                                            static_cast<size_t>(length - offset)),
            static_cast<size_t>(stride)};
}

void GltfFile::read_values(const View& view, size_t count, int64_t type, bool normalized,
                           const JsonValue& at, GltfArray* out) {
    const ComponentType& component = *find_type(type);
    const size_t size = component.bytes * out->components;
    const size_t stride = view.stride == 0 ? size : view.stride;
    const size_t room =
        view.bytes.size() < size ? 0 : 1 + (view.bytes.size() - size) / std::max(stride, size);
    if (stride < size || count > room) {
        fail(at, fmt::format(messages::kAccessorTooShort, count, size, stride < size ? 0 : room));
        return;
    }
    out->values.reserve(count * out->components);
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < out->components; ++c) {
            double value = read_number(view.bytes.data() + i * stride + c * component.bytes, type);
            if (normalized && component.most > 0) value = std::max(value / component.most, -1.0);
            out->values.push_back(value);
        }
    }
}

void GltfFile::apply_sparse(const JsonValue& sparse, int64_t type, bool normalized,
                            GltfArray* out) {
    const auto count = static_cast<size_t>(integer(sparse, "count", 0));
    const JsonMember* indices = sparse.find("indices");
    const JsonMember* values = sparse.find("values");
    if (indices == nullptr || values == nullptr) return fail(sparse, messages::kSparseIncomplete);
    // Each node that repeats the mesh reads them again, and is counted by the accessor.
    if (ok() && count > out->count())
        return fail(sparse, fmt::format(messages::kSparseTooMany, count, out->count()));
    GltfArray targets;
    GltfArray replaced;
    replaced.components = out->components;
    const int64_t index_type = integer(indices->value, "componentType", 0);
    if (ok() && index_type != 5121 && index_type != 5123 && index_type != 5125)
        fail(indices->value, messages::kIndicesUnsigned);
    const auto view_of = [&](const JsonValue& part) {
        return view(integer(part, "bufferView", 0), integer(part, "byteOffset", 0), part);
    };
    if (ok()) {
        const View v = view_of(indices->value);
        if (ok()) read_values(v, count, index_type, false, indices->value, &targets);
    }
    if (ok()) {
        const View v = view_of(values->value);
        if (ok()) read_values(v, count, type, normalized, values->value, &replaced);
    }
    for (size_t i = 0; i < count && ok(); ++i) {
        if (!(targets.values[i] < static_cast<double>(out->count())))
            return fail(sparse, messages::kSparseIndexPastEnd);
        const size_t to = static_cast<size_t>(targets.values[i]) * out->components;
        for (size_t c = 0; c < out->components; ++c)
            out->values[to + c] = replaced.values[i * out->components + c];
    }
}

Result<GltfArray> GltfFile::array(int64_t accessor, Use use) {
    const JsonValue* value = item("accessors", accessor, "a mesh");
    if (value == nullptr) return error();
    GltfArray out;
    static constexpr std::string_view kShapes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const std::string shape = text(*value, "type");
    const auto* found = std::find(std::begin(kShapes), std::end(kShapes), shape);
    const bool matrices = use == Use::kMatrices;
    if (matrices ? shape != "MAT4" : found == std::end(kShapes))
        fail(*value, fmt::format(messages::kAccessorType, shape.substr(0, 20)),
             matrices ? messages::kAccessorTypeMatrix : messages::kAccessorTypeHelp);
    out.components = matrices ? 16 : static_cast<size_t>(found - std::begin(kShapes)) + 1;
    const int64_t type = integer(*value, "componentType", 0);
    const int64_t count = integer(*value, "count", 0);
    if (ok() && find_type(type) == nullptr)
        fail(*value, fmt::format(messages::kUnknownComponentType, type));
    if (ok() && use == Use::kIndices &&
        (out.components != 1 || (type != 5121 && type != 5123 && type != 5125)))
        fail(*value, messages::kIndicesScalar);
    constexpr int64_t kFloat = 5126;
    if (ok() && matrices && type != kFloat) fail(*value, messages::kMatricesOfFloats);
    const JsonMember* normalized = value->find("normalized");
    const bool is_normalized =
        use == Use::kShares || (normalized != nullptr && normalized->value.boolean);
    if (!ok()) return error();
    if (value->find("bufferView") != nullptr) {
        const View v =
            view(integer(*value, "bufferView", 0), integer(*value, "byteOffset", 0), *value);
        if (ok()) read_values(v, static_cast<size_t>(count), type, is_normalized, *value, &out);
    } else if (count > kMaxZeros) {
        fail(*value, fmt::format(messages::kAccessorWithoutView, count));
    } else {
        out.values.resize(static_cast<size_t>(count) * out.components);
    }
    if (const JsonMember* sparse = value->find("sparse"); sparse != nullptr && ok())
        apply_sparse(sparse->value, type, is_normalized, &out);
    if (!ok()) return error();
    return out;
}

}  // namespace openfab::mesh
