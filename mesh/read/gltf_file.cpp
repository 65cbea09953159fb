// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/base64.h"
#include "base/input_file.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMagic = 0x46546C67;        ///< "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;    ///< "JSON"
constexpr uint32_t kBinaryChunk = 0x004E4942;  ///< "BIN"
constexpr size_t kLargestBuffer = 2'000'000'000;
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

uint32_t word_at(std::string_view bytes, size_t at) {
    uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

/// Decodes `%20` and the like in a URI.
std::string decode_percent(const std::string& uri) {
    std::string out;
    for (size_t i = 0; i < uri.size(); ++i) {
        const auto digit = [&](size_t at) -> int {
            const char c = at < uri.size() ? uri[at] : ' ';
            if (c >= '0' && c <= '9') return c - '0';
            if (c >= 'a' && c <= 'f') return c - 'a' + 10;
            return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
        };
        if (uri[i] == '%' && digit(i + 1) >= 0 && digit(i + 2) >= 0) {
            out.push_back(static_cast<char>(digit(i + 1) * 16 + digit(i + 2)));
            i += 2;
        } else {
            out.push_back(uri[i]);
        }
    }
    return out;
}

}  // namespace

Result<GltfFile> GltfFile::open(std::string_view bytes, const std::string& file,
                                int64_t memory_bytes) {
    GltfFile out;
    out.file_ = file;
    out.memory_left_ = memory_bytes;
    std::string_view json = bytes;
    if (bytes.size() >= 12 && word_at(bytes, 0) == kMagic) {
        const uint32_t version = word_at(bytes, 4);
        if (version != 2)
            return user_error(fmt::format("{}: glTF {}; this program reads glTF 2", file, version));
        json = {};
        for (size_t at = 12; at + 8 <= bytes.size();) {
            const size_t length = word_at(bytes, at);
            const uint32_t kind = word_at(bytes, at + 4);
            if (length > bytes.size() - at - 8)
                return user_error(fmt::format("{}: the file was cut short in a chunk", file));
            const std::string_view chunk = bytes.substr(at + 8, length);
            if (kind == kJsonChunk && json.empty()) json = chunk;
            if (kind == kBinaryChunk && !out.binary_) {
                out.memory_left_ -= static_cast<int64_t>(length);
                if (out.memory_left_ < 0)
                    return user_error(
                        fmt::format("{}: its binary chunk of {} MB takes more memory "
                                    "than is allowed; allow more with `--memory`",
                                    file, length / 1'000'000));
                out.binary_ = std::string(chunk);
            }
            at += 8 + length;
        }
        // The chunk is padded to a multiple of 4 bytes.
        while (json.ends_with('\0'))
            json.remove_suffix(1);
    }
    Result<JsonValue> root = parse_json(json, file, out.memory_left_);
    if (!root) return root.error();
    out.root_ = std::move(*root);
    out.memory_left_ -= json_bytes(out.root_);
    if (Result<void> fine = out.check_version(); !fine) return fine.error();
    if (const JsonMember* buffers = out.root_.find("buffers"))
        out.buffers_.resize(buffers->value.items.size());
    return out;
}

Result<void> GltfFile::check_version() {
    const JsonMember* asset = root_.is(JsonValue::Kind::kObject) ? root_.find("asset") : nullptr;
    const std::string version = asset != nullptr ? text(asset->value, "version") : "";
    if (!version.starts_with("2."))
        return user_error(fmt::format("{}: not a glTF 2.0 file: `asset` has {}", file_,
                                      version.empty() ? "no `version`" : "version " + version));
    const JsonMember* required = root_.find("extensionsRequired");
    if (required == nullptr) return Ok{};
    for (const JsonValue& name : required->value.items) {
        // Quantised accessors are read as they are; materials do not matter to a mesh.
        if (name.text == "KHR_mesh_quantization" || name.text.starts_with("KHR_materials_"))
            continue;
        return error_at(
            {file_, name.line, name.column},
            fmt::format("the file requires `{}`, which is not supported", name.text.substr(0, 60)),
            "export it without compression and extensions");
    }
    return Ok{};
}

void GltfFile::fail(const JsonValue& at, const std::string& what, const std::string& help) {
    if (!error_) error_ = error_at({file_, at.line, at.column}, what, help);
}

std::string GltfFile::text(const JsonValue& object, const char* key) {
    const JsonMember* m = object.find(key);
    return m != nullptr && m->value.is(JsonValue::Kind::kString) ? m->value.text : std::string();
}

int64_t GltfFile::integer(const JsonValue& object, const char* key, int64_t otherwise,
                          int64_t most) {
    const JsonMember* m = object.find(key);
    if (m == nullptr) return otherwise;
    const double value = m->value.number;
    if (!m->value.is(JsonValue::Kind::kNumber) || value != std::floor(value) || value < 0 ||
        value > static_cast<double>(most)) {
        fail(m->value, fmt::format("`{}` is not a whole number from 0 to {}", key, most));
        return 0;
    }
    return static_cast<int64_t>(value);
}

std::optional<std::vector<double>> GltfFile::numbers(const JsonValue& object, const char* key,
                                                     size_t count) {
    const JsonMember* m = object.find(key);
    if (m == nullptr) return {};
    std::vector<double> out;
    for (const JsonValue& item : m->value.items) {
        if (item.is(JsonValue::Kind::kNumber)) out.push_back(item.number);
    }
    if (out.size() == count && m->value.items.size() == count) return out;
    fail(m->value, fmt::format("`{}` is not an array of {} numbers", key, count));
    return {};
}

const JsonValue* GltfFile::item(const char* key, int64_t index, const char* asked_by) {
    const JsonMember* list = root_.find(key);
    const size_t count = list != nullptr ? list->value.items.size() : 0;
    if (index < 0 || static_cast<size_t>(index) >= count) {
        fail(list != nullptr ? list->value : root_,
             fmt::format("{} refers to {} {}, but there are {}", asked_by, key, index, count));
        return nullptr;
    }
    return &list->value.items[index];
}

std::string GltfFile::load_uri(const JsonValue& at, const std::string& uri) {
    const auto allowed = static_cast<size_t>(
        std::clamp<int64_t>(memory_left_, 0, static_cast<int64_t>(kLargestBuffer)));
    if (uri.starts_with("data:")) {
        constexpr std::string_view kMark = ";base64,";
        const size_t mark = uri.find(kMark);
        if (uri.size() / 4 * 3 > allowed) {
            fail(at, "the data takes more memory than is allowed", "allow more with `--memory`");
            return {};
        }
        std::string bytes = mark == std::string::npos
                                ? std::string()
                                : decode_base64(std::string_view(uri).substr(mark + kMark.size()));
        if (bytes.empty()) fail(at, "the data is not valid base64");
        memory_left_ -= static_cast<int64_t>(bytes.size());
        return bytes;
    }
    const fs::path relative = decode_percent(uri);
    const bool up = std::find(relative.begin(), relative.end(), fs::path("..")) != relative.end();
    if (relative.empty() || relative.is_absolute() || up ||
        relative.string().find('\0') != std::string::npos ||
        relative.string().find("://") != std::string::npos) {
        fail(at, fmt::format("the file `{}` must be in the folder of the mesh, or below",
                             uri.substr(0, 200)));
        return {};
    }
    const fs::path folder = fs::path(file_).parent_path();
    const fs::path path = folder / relative;
    // Nor may a symbolic link lead out of it.
    Result<std::string> bytes = read_text_file(path, allowed, {reading_root(folder)});
    if (!bytes) {
        fail(at, bytes.error().message, bytes.error().help);
        return {};
    }
    files_.push_back(path);
    memory_left_ -= static_cast<int64_t>(bytes->size());
    return std::move(*bytes);
}

Result<std::string> GltfFile::image(const JsonValue& image) {
    std::string bytes;
    if (const std::string uri = text(image, "uri"); !uri.empty()) {
        bytes = load_uri(image, uri);
        memory_left_ += static_cast<int64_t>(bytes.size());
    } else {
        const JsonValue* found = item("bufferViews", integer(image, "bufferView", 0), "an image");
        const int64_t length = found != nullptr ? integer(*found, "byteLength", 0) : 0;
        const View of = found != nullptr ? view(integer(image, "bufferView", 0), 0, image) : View{};
        if (ok() && length > memory_left_)
            fail(image, "the image takes more memory than is allowed; allow more with `--memory`");
        if (ok()) bytes = std::string(of.bytes.substr(0, static_cast<size_t>(length)));
    }
    if (!ok()) return error();
    return bytes;
}

const std::string* GltfFile::buffer(int64_t index) {
    const JsonValue* buffer = item("buffers", index, "a buffer view");
    if (buffer == nullptr) return nullptr;
    std::optional<std::string>& bytes = buffers_[index];
    if (!bytes) {
        const std::string uri = text(*buffer, "uri");
        if (uri.empty() && index == 0 && binary_) {
            bytes = std::move(*binary_);
        } else if (uri.empty()) {
            fail(*buffer, "the buffer has no `uri`, and the file no binary chunk for it");
        } else {
            bytes = load_uri(*buffer, uri);
        }
    }
    return ok() ? &*bytes : nullptr;
}

GltfFile::View GltfFile::view(int64_t index, int64_t offset, const JsonValue& asked_by) {
    const JsonValue* view = item("bufferViews", index, "an accessor");
    if (view == nullptr) return {};
    const std::string* bytes = buffer(integer(*view, "buffer", 0));
    const int64_t start = integer(*view, "byteOffset", 0);
    const int64_t length = integer(*view, "byteLength", 0);
    const int64_t stride = integer(*view, "byteStride", 0, 252);
    if (!ok()) return {};
    const auto size = static_cast<int64_t>(bytes->size());
    if (start > size || length > size - start) {
        fail(*view, fmt::format("the buffer view ends at byte {} of a buffer of {} bytes",
                                start + length, size));
        return {};
    }
    if (offset > length) {
        fail(asked_by, "the accessor starts past the end of its buffer view");
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
        fail(at, fmt::format("the accessor needs {} elements of {} bytes, but there are {}", count,
                             size, stride < size ? 0 : room));
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
    if (indices == nullptr || values == nullptr)
        return fail(sparse, "`sparse` has no `indices` and `values`");
    // Each node that repeats the mesh reads them again, and is counted by the accessor.
    if (ok() && count > out->count())
        return fail(sparse, fmt::format("`sparse` replaces {} elements of an accessor of {}", count,
                                        out->count()));
    GltfArray targets;
    GltfArray replaced;
    replaced.components = out->components;
    const int64_t index_type = integer(indices->value, "componentType", 0);
    if (ok() && index_type != 5121 && index_type != 5123 && index_type != 5125)
        fail(indices->value, "indices must be of an unsigned integer type");
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
            return fail(sparse, "a sparse index is past the end of its accessor");
        const size_t to = static_cast<size_t>(targets.values[i]) * out->components;
        for (size_t c = 0; c < out->components; ++c)
            out->values[to + c] = replaced.values[i * out->components + c];
    }
}

Result<GltfArray> GltfFile::array(int64_t accessor, bool indices) {
    const JsonValue* value = item("accessors", accessor, "a mesh");
    if (value == nullptr) return error();
    GltfArray out;
    static constexpr std::string_view kShapes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const std::string shape = text(*value, "type");
    const auto* found = std::find(std::begin(kShapes), std::end(kShapes), shape);
    if (found == std::end(kShapes))
        fail(*value, fmt::format("the accessor's type is `{}`", shape.substr(0, 20)),
             "SCALAR and VEC2 to VEC4 are supported");
    out.components = static_cast<size_t>(found - std::begin(kShapes)) + 1;
    const int64_t type = integer(*value, "componentType", 0);
    const int64_t count = integer(*value, "count", 0);
    if (ok() && find_type(type) == nullptr)
        fail(*value, fmt::format("unknown componentType {}", type));
    if (ok() && indices && (out.components != 1 || (type != 5121 && type != 5123 && type != 5125)))
        fail(*value, "indices must be SCALAR and of an unsigned integer type");
    const JsonMember* normalized = value->find("normalized");
    const bool is_normalized = normalized != nullptr && normalized->value.boolean;
    if (!ok()) return error();
    if (value->find("bufferView") != nullptr) {
        const View v =
            view(integer(*value, "bufferView", 0), integer(*value, "byteOffset", 0), *value);
        if (ok()) read_values(v, static_cast<size_t>(count), type, is_normalized, *value, &out);
    } else if (count > kMaxZeros) {
        fail(*value, fmt::format("an accessor of {} elements without a buffer view", count));
    } else {
        out.values.resize(static_cast<size_t>(count) * out.components);
    }
    if (const JsonMember* sparse = value->find("sparse"); sparse != nullptr && ok())
        apply_sparse(sparse->value, type, is_normalized, &out);
    if (!ok()) return error();
    return out;
}

}  // namespace openfab::mesh
