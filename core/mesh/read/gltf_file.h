// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The glTF 2.0 container: its JSON, its buffers (embedded or in files), and the arrays in them.
//
// Not based on tinygltf, which Debian has: it would replace this file alone, of eight. On 9,000 damaged files it was safe
// (under the address sanitizer), but it took nine whose accessors lie outside their buffers, its errors name no place, and
// it allocates what a file asks for without a limit.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "base/json.h"
#include "base/result.h"
#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// Numbers of an accessor; normalised ones are already between 0 (or -1) and 1.
struct GltfArray {
    size_t components = 1;  ///< 1 to 4; 16 for matrices
    std::vector<double> values;
    size_t count() const { return values.size() / components; }
};

/// An open glTF file.
class GltfFile {
  public:
    /// Opens `.gltf` text or `.glb`; buffers are read on demand. Errors: not glTF 2.0, cut short,
    /// an unknown required extension, or a file that does not fit into `memory_bytes` beside
    /// `bytes`.
    static Result<GltfFile> open(std::string_view bytes, const std::string& file,
                                 int64_t memory_bytes = kDefaultReadingBytes);

    /// Returns what remains of memory_bytes after the tree, the buffers read so far, and
    /// allocations of others.
    int64_t memory_left() const { return memory_left_; }
    int64_t& memory_left() { return memory_left_; }

    const JsonValue& root() const { return root_; }

    /// Reads one of `accessors`. kIndices must be of an unsigned integer type; integers of kShares
    /// are normalised, whether the accessor says so or not; kMatrices are MAT4 of floats, by
    /// columns, which others cannot be.
    enum class Use { kNumbers, kIndices, kShares, kMatrices };
    Result<GltfArray> array(int64_t accessor, Use use);

    /// Reads the bytes of one of `images`: its file, its data, or its buffer view. At most
    /// memory_left(), from which the caller deducts what it keeps.
    Result<std::string> image(const JsonValue& image);
    /// Same of images[index]; an error is returned, and not kept.
    Result<std::string> image_at(int64_t index);

    /// Returns the bytes of an image's head where they are at hand without reading a file, else
    /// none.
    std::string image_head(const JsonValue& image) const;

    /// Takes memory for what is kept beside the mesh; false after an error.
    bool take_memory(size_t bytes, const JsonValue& at);

    /// Returns root()[key][index]; null after an error, which is kept for error().
    const JsonValue* item(const char* key, int64_t index, const char* asked_by);
    /// Returns object[key] as a whole number, `otherwise` if absent; 0 after an error.
    int64_t integer(const JsonValue& object, const char* key, int64_t otherwise,
                    int64_t most = 1LL << 40);
    /// Returns object[key] as `count` numbers; none if absent.
    std::optional<std::vector<double>> numbers(const JsonValue& object, const char* key,
                                               size_t count);
    /// Returns object[key] as text, empty if absent.
    static std::string text(const JsonValue& object, const char* key);

    bool ok() const { return !error_.has_value(); }
    const Error& error() const {
        OPENFAB_CHECK(!ok());
        return *error_;
    }
    void fail(const JsonValue& at, const std::string& what, const std::string& help = {});

    /// Returns `node \`wheel\``, or where in the file a thing without a name is.
    std::string place_of(const char* kind, const JsonValue& thing) const;

    /// Files read besides this one.
    const std::vector<std::filesystem::path>& files() const { return files_; }

  private:
    struct View {
        std::string_view bytes;
        size_t stride = 0;  ///< 0: packed
    };

    Result<void> check_version();
    const std::string* buffer(int64_t index);
    std::string load_uri(const JsonValue& at, const std::string& uri);
    View view(int64_t index, int64_t offset, const JsonValue& asked_by);
    void read_values(const View& view, size_t count, int64_t type, bool normalized,
                     const JsonValue& at, GltfArray* out);
    void apply_sparse(const JsonValue& sparse, int64_t type, bool normalized, GltfArray* out);

    std::string file_;
    int64_t memory_left_ = 0;
    JsonValue root_;
    std::optional<std::string> binary_;  ///< the chunk of a .glb
    std::vector<std::optional<std::string>> buffers_;
    std::vector<std::filesystem::path> files_;
    std::optional<Error> error_;
};

/// Returns object[key]; null if absent, or if there is no object.
const JsonValue* gltf_member(const JsonValue* object, std::string_view key);
/// Returns object.extensions[name], or null.
const JsonValue* gltf_extension(const JsonValue* object, std::string_view name);

/// Decodes `%20` and the like in a URI.
std::string decode_percent(std::string_view uri);

}  // namespace openfab::mesh
