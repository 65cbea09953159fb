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
#include "mesh/read/gltf_types.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMagic = 0x46546C67;        ///< "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;    ///< "JSON"
constexpr uint32_t kBinaryChunk = 0x004E4942;  ///< "BIN"
constexpr size_t kLargestBuffer = 2'000'000'000;
uint32_t word_at(std::string_view bytes, size_t at) {
    uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

constexpr std::string_view kCompressed[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                            "KHR_meshopt_compression"};

/// Required extensions that do not change where surfaces are, or that are read. Others may.
constexpr std::string_view kPossible[] = {"KHR_mesh_quantization",
                                          "KHR_texture_transform",
                                          "KHR_texture_basisu",
                                          "EXT_texture_webp",
                                          "EXT_texture_avif",
                                          "EXT_mesh_gpu_instancing",
                                          "KHR_lights_punctual",
                                          "KHR_node_visibility",
                                          "KHR_animation_pointer",
                                          "KHR_xmp_json_ld",
                                          "KHR_xmp",
                                          "MSFT_lod",
                                          "MSFT_texture_dds",
                                          "EXT_lights_image_based"};

/// The names that a URI may mean: programs forget to encode, and some write backslashes.
std::vector<fs::path> names_of(const std::string& uri) {
    std::vector<fs::path> names{decode_percent(uri), uri};
    std::string slashes = decode_percent(uri);
    std::replace(slashes.begin(), slashes.end(), '\\', '/');
    names.emplace_back(slashes);
    return names;
}

bool may_be_read(const fs::path& relative) {
    const bool up = std::find(relative.begin(), relative.end(), fs::path("..")) != relative.end();
    return !relative.empty() && !relative.is_absolute() && !up &&
           relative.string().find('\0') == std::string::npos &&
           relative.string().find("://") == std::string::npos;
}

/// Splits a `data:` URI; returns false where it has no data.
bool split_data(std::string_view uri, std::string_view* data, bool* base64) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) return false;
    *base64 = uri.substr(0, comma).ends_with(";base64");
    *data = uri.substr(comma + 1);
    return true;
}

}  // namespace

const JsonValue* gltf_member(const JsonValue* object, std::string_view key) {
    const JsonMember* found = object != nullptr ? object->find(key) : nullptr;
    return found != nullptr ? &found->value : nullptr;
}

const JsonValue* gltf_extension(const JsonValue* object, std::string_view name) {
    return gltf_member(gltf_member(object, "extensions"), name);
}

std::string decode_percent(std::string_view uri) {
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

Result<GltfFile> GltfFile::open(std::string_view bytes, const std::string& file,
                                int64_t memory_bytes) {
    GltfFile out;
    out.file_ = file;
    out.memory_left_ = memory_bytes;
    std::string_view json = bytes;
    if (bytes.size() >= 12 && word_at(bytes, 0) == kMagic) {
        const uint32_t version = word_at(bytes, 4);
        if (version != 2) return user_error(fmt::format(messages::kOldGltf, file, version));
        json = {};
        // What stands behind the length that the file states is not glTF.
        if (const size_t stated = word_at(bytes, 8); stated >= 20 && stated < bytes.size())
            bytes = bytes.substr(0, stated);
        for (size_t at = 12; at + 8 <= bytes.size();) {
            const size_t length = word_at(bytes, at);
            const uint32_t kind = word_at(bytes, at + 4);
            if (length > bytes.size() - at - 8)
                return user_error(fmt::format(messages::kCutShortInChunk, file));
            const std::string_view chunk = bytes.substr(at + 8, length);
            if (kind == kJsonChunk && json.empty()) json = chunk;
            if (kind == kBinaryChunk && !out.binary_) {
                out.memory_left_ -= static_cast<int64_t>(length);
                if (out.memory_left_ < 0)
                    return user_error(
                        fmt::format(messages::kChunkTakesTooMuch, file, length / 1'000'000));
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
    if (Result<void> fine = check_gltf_types(out.root_, file); !fine) return fine.error();
    if (const JsonMember* buffers = out.root_.find("buffers"))
        out.buffers_.resize(buffers->value.items.size());
    return out;
}

Result<void> GltfFile::check_version() {
    const JsonMember* asset = root_.is(JsonValue::Kind::kObject) ? root_.find("asset") : nullptr;
    const std::string version = asset != nullptr ? text(asset->value, "version") : "";
    if (!version.starts_with("2."))
        return user_error(fmt::format(
            messages::kNotGltf2, file_,
            version.empty() ? messages::kNoVersion
                            : "version " + version.substr(0, 20) + messages::kNotGltf2Remedy));
    const std::string least = text(asset->value, "minVersion");
    if (!least.empty() && least != "2.0")
        return user_error(fmt::format(messages::kNewerGltf, file_, least.substr(0, 20)));
    const JsonMember* required = root_.find("extensionsRequired");
    if (required == nullptr) return Ok{};
    const auto is_in = [](const auto& list, std::string_view name) {
        return std::find(std::begin(list), std::end(list), name) != std::end(list);
    };
    for (const JsonValue& name : required->value.items) {
        // Looks have no say in where surfaces are: what cannot be shown is told.
        if (is_in(kPossible, name.text) || name.text.starts_with("KHR_materials_")) continue;
        return error_at({file_, name.line, name.column},
                        fmt::format(messages::kRequiresExtension, name.text.substr(0, 60)),
                        is_in(kCompressed, name.text) ? messages::kRequiresCompression
                                                      : messages::kExportWithoutExtension);
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
        fail(m->value, fmt::format(messages::kNotWholeNumber, key, most));
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
    fail(m->value, fmt::format(messages::kNotArrayOfNumbers, key, count));
    return {};
}

const JsonValue* GltfFile::item(const char* key, int64_t index, const char* asked_by) {
    const JsonMember* list = root_.find(key);
    const size_t count = list != nullptr ? list->value.items.size() : 0;
    if (index < 0 || static_cast<size_t>(index) >= count) {
        fail(list != nullptr ? list->value : root_,
             fmt::format(messages::kRefersToNone, asked_by, key, index, count));
        return nullptr;
    }
    return &list->value.items[index];
}

std::string GltfFile::load_uri(const JsonValue& at, const std::string& uri) {
    const auto allowed = static_cast<size_t>(
        std::clamp<int64_t>(memory_left_, 0, static_cast<int64_t>(kLargestBuffer)));
    if (uri.starts_with("data:")) {
        if (uri.size() / 4 * 3 > allowed) {
            fail(at, messages::kDataTakesTooMuch, messages::kAllowMoreMemory);
            return {};
        }
        std::string_view data;
        bool base64 = false;
        std::string bytes;
        if (split_data(uri, &data, &base64)) {
            const bool encoded = !base64 || data.find('%') != std::string_view::npos;
            bytes = encoded ? decode_percent(data) : std::string();
            if (base64) bytes = decode_base64(encoded ? bytes : data);
        }
        if (bytes.empty()) fail(at, messages::kNotBase64);
        memory_left_ -= static_cast<int64_t>(bytes.size());
        return bytes;
    }
    const fs::path folder = fs::path(file_).parent_path();
    std::optional<fs::path> relative;
    for (const fs::path& name : names_of(uri)) {
        std::error_code ignored;
        if (!may_be_read(name)) continue;
        if (!relative) relative = name;
        if (!fs::exists(folder / name, ignored)) continue;
        relative = name;
        break;
    }
    if (!relative) {
        fail(at, fmt::format(messages::kFileOutsideFolder, uri.substr(0, 200)));
        return {};
    }
    const fs::path path = folder / *relative;
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

bool GltfFile::take_memory(size_t bytes, const JsonValue& at) {
    memory_left_ -= static_cast<int64_t>(bytes);
    if (memory_left_ < 0) fail(at, messages::kGltfNamesTakeTooMuch, messages::kAllowMoreMemory);
    return ok();
}

std::string GltfFile::place_of(const char* kind, const JsonValue& thing) const {
    constexpr size_t kLongest = 100;
    const std::string name = text(thing, "name");
    if (name.empty()) return fmt::format("{}:{}:{}", file_, thing.line, thing.column);
    return fmt::format("{} `{}`", kind, name.substr(0, kLongest));
}

Result<std::string> GltfFile::image_at(int64_t index) {
    const JsonValue* found = item("images", index, "a texture");
    Result<std::string> bytes = found != nullptr ? image(*found) : Result<std::string>(error());
    error_.reset();
    return bytes;
}

std::string GltfFile::image_head(const JsonValue& image) const {
    constexpr size_t kHead = 16;
    if (const std::string uri = text(image, "uri"); uri.starts_with("data:")) {
        std::string_view data;
        bool base64 = false;
        if (!split_data(uri, &data, &base64) || !base64) return {};
        return decode_base64(data.substr(0, kHead));
    }
    const JsonValue* index = gltf_member(&image, "bufferView");
    const JsonValue* views = gltf_member(&root_, "bufferViews");
    const auto below = [](const JsonValue* number, size_t limit) -> std::optional<size_t> {
        const double value = number != nullptr ? number->number : 0;
        if (!(value >= 0 && value < static_cast<double>(limit))) return {};
        return static_cast<size_t>(value);
    };
    if (index == nullptr || views == nullptr) return {};
    const std::optional<size_t> number = below(index, views->items.size());
    if (!number) return {};
    const JsonValue& view = views->items[*number];
    const std::optional<size_t> buffer = below(gltf_member(&view, "buffer"), buffers_.size());
    if (!buffer) return {};
    const std::optional<std::string>& bytes =
        *buffer == 0 && !buffers_[0] ? binary_ : buffers_[*buffer];
    if (!bytes) return {};
    const std::optional<size_t> at = below(gltf_member(&view, "byteOffset"), bytes->size());
    return at ? bytes->substr(*at, kHead) : std::string();
}

Result<std::string> GltfFile::image(const JsonValue& image) {
    std::string bytes;
    if (const std::string uri = text(image, "uri"); !uri.empty()) {
        bytes = load_uri(image, uri);
        memory_left_ += static_cast<int64_t>(bytes.size());
    } else if (image.find("bufferView") == nullptr) {
        fail(image, messages::kImageWithoutSource);
    } else {
        const JsonValue* found =
            item("bufferViews", integer(image, "bufferView", 0), messages::kAnImage);
        const int64_t length = found != nullptr ? integer(*found, "byteLength", 0) : 0;
        const View of = found != nullptr ? view(integer(image, "bufferView", 0), 0, image) : View{};
        if (ok() && length > memory_left_) fail(image, messages::kImageTakesTooMuch);
        if (ok()) bytes = std::string(of.bytes.substr(0, static_cast<size_t>(length)));
    }
    if (!ok()) return error();
    return bytes;
}

const std::string* GltfFile::buffer(int64_t index) {
    const JsonValue* buffer = item("buffers", index, messages::kABufferView);
    if (buffer == nullptr) return nullptr;
    std::optional<std::string>& bytes = buffers_[index];
    if (!bytes) {
        const std::string uri = text(*buffer, "uri");
        const bool is_stand_in =
            uri.empty() && (gltf_extension(buffer, kCompressed[1]) != nullptr ||
                            gltf_extension(buffer, kCompressed[2]) != nullptr);
        if (is_stand_in) {
            fail(*buffer, messages::kCompressedWithMeshopt, messages::kExportWithoutCompression);
        } else if (uri.empty() && index == 0 && binary_) {
            bytes = std::move(*binary_);
        } else if (uri.empty()) {
            fail(*buffer, messages::kBufferWithoutSource);
        } else {
            bytes = load_uri(*buffer, uri);
        }
    }
    return ok() ? &*bytes : nullptr;
}

}  // namespace openfab::mesh
