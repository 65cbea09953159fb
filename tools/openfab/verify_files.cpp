// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/verify_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "abi/stages.h"
#include "backends/common/tee_sink.h"
#include "backends/raster/fraction_file.h"
#include "backends/raster/npy.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/slice_digests.h"
#include "backends/raster/slice_files.h"
#include "backends/read/gcvf_print.h"
#include "backends/read/print_file.h"
#include "base/input_file.h"
#include "base/say.h"
#include "base/sha256.h"
#include "base/text.h"
#include "mesh/read/zip_file.h"
#include "runtime/pipeline/print_hash.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr const char* kManifest = "manifest.json";

int64_t number_of(const JsonValue& object, std::string_view name) {
    const JsonValue* const value = member_of(object, name);
    return value != nullptr ? value->whole().value_or(0) : 0;
}

std::string text_of(const JsonValue& object, std::string_view name) {
    const JsonValue* const value = member_of(object, name);
    return value != nullptr ? value->text : std::string();
}

bool is_true(const JsonValue& object, std::string_view name) {
    const JsonValue* const value = member_of(object, name);
    return value != nullptr && value->boolean;
}

Result<std::string> read_file(const fs::path& path, int64_t most) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file)
        return with_context(file.error(), fmt::format(messages::kCannotReadFile, path.string()));
    return file->read_all(most);
}

Result<JsonValue> read_note(const fs::path& path) {
    const Result<std::string> text = read_file(path, raster::kMostManifestBytes);
    if (!text) return text.error();
    std::optional<JsonValue> root = raster::parse_manifest(*text);
    if (!root) return user_error(fmt::format(messages::kFolderDamaged, path.string()));
    return std::move(*root);
}

/// Digests a file piece by piece; none where it cannot be read.
std::optional<Sha256Digest> digest_of(const fs::path& path) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return {};
    Sha256 sum;
    std::vector<uint8_t> bytes(1 << 20);
    for (int64_t at = 0;;) {
        const Result<size_t> read = file->read(at, bytes.data(), bytes.size());
        if (!read) return {};
        sum.add(std::span(bytes).first(*read));
        if (*read < bytes.size()) return sum.digest();
        at += static_cast<int64_t>(*read);
    }
}

/// The names of a folder's slices, from those of its first file and the numbers in its manifest.
std::vector<std::string> names_of(const JsonValue& manifest) {
    pipeline::PrintInfo info;
    raster::FolderOptions options;
    const std::string first = text_of(manifest, "first_file");
    const std::string mode = text_of(manifest, "color_mode");
    if (mode == "bitmaps") options.format = raster::SliceFormat::kBitmaps;
    if (first.ends_with(".tif")) options.format = raster::SliceFormat::kTiff8;
    if (const JsonValue* const materials = member_of(manifest, "materials"))
        info.materials.resize(materials->items.size());
    // A name has as many digits as the number of slices in the whole grid.
    const size_t digits = first.find_first_not_of("0123456789", 6);
    if (digits == std::string::npos || digits < 7 || digits > 6 + 9) return {};
    for (size_t i = 0; i < digits - 6; ++i)
        info.size.z = info.size.z * 10 + 9;
    const int64_t begin = number_of(manifest, "first_slice_z");
    const int64_t end = begin + number_of(manifest, "slices");
    std::vector<std::string> names;
    if (begin < 0 || end > info.size.z) return names;
    for (auto z = static_cast<int32_t>(begin); z < end; ++z) {
        for (size_t i = 0; i < raster::files_a_slice(info, options); ++i)
            names.push_back(raster::slice_file_name(z, i, info, options));
    }
    return names;
}

/// What is wrong with the files of a folder, each in a few words.
std::vector<std::string> wrong_files(const fs::path& folder, const FolderFiles& files,
                                     const std::string& manifest) {
    const raster::Digests digests = raster::manifest_digests(manifest);
    const raster::Digests seals = raster::manifest_seals(manifest);
    const auto identity = raster::print_identity(manifest).value_or(Sha256Digest{});
    std::vector<std::string> wrong;
    const std::set<std::string> expected(files.names.begin(), files.names.end());
    const std::set<std::string> missing(files.missing.begin(), files.missing.end());
    const auto check = [&](const std::string& name, const std::optional<Sha256Digest>& recorded) {
        const std::optional<Sha256Digest> found = digest_of(folder / name);
        if (!found)
            wrong.push_back(fmt::format(messages::kFileMissing, name));
        else if (!recorded || *found != *recorded)
            wrong.push_back(fmt::format(messages::kFileDiffers, name));
    };
    for (const std::string& name : files.names) {
        if (missing.contains(name)) {
            wrong.push_back(fmt::format(messages::kFileMissing, name));
        } else if (!digests.empty()) {
            const auto recorded = digests.find(name);
            const auto seal = seals.find(name);
            check(name, recorded == digests.end() ? std::nullopt : std::optional(recorded->second));
            // The digest of another print's slice, or of another place's, came with it.
            if (recorded != digests.end() &&
                (seal == seals.end() ||
                 seal->second != raster::seal_of(identity, name, recorded->second)))
                wrong.push_back(fmt::format(messages::kFileOfOther, name));
        }
    }
    std::error_code ended;
    for (fs::directory_iterator at(folder, ended); !ended && at != fs::directory_iterator();
         at.increment(ended)) {
        const std::string name = at->path().filename().string();
        if (raster::is_slice_name(name) && !expected.contains(name))
            wrong.push_back(fmt::format(messages::kFileOfOther, name));
    }
    if (digests.empty()) return wrong;
    // Their list has the notes, too.
    const Result<std::string> list =
        read_file(folder / raster::kDigestFile, raster::kMostManifestBytes);
    if (!list) {
        wrong.push_back(fmt::format(messages::kFileMissing, raster::kDigestFile));
        return wrong;
    }
    const raster::Digests listed = raster::parse_digests(*list, "");
    for (const auto& [name, digest] : listed) {
        if (!expected.contains(name)) check(name, digest);
    }
    for (const auto& [name, digest] : digests) {
        const auto other = listed.find(name);
        if (other != listed.end() && other->second == digest) continue;
        wrong.push_back(fmt::format(messages::kFileDiffers, raster::kDigestFile));
        break;
    }
    return wrong;
}

}  // namespace

FolderFiles look_for_files(const fs::path& folder, const JsonValue& manifest) {
    FolderFiles files;
    files.names = names_of(manifest);
    for (const std::string& name : files.names) {
        std::error_code ignored;
        if (!fs::is_regular_file(folder / name, ignored)) files.missing.push_back(name);
    }
    return files;
}

Result<void> verify_folder(const fs::path& folder, int64_t memory_bytes) {
    std::error_code ignored;
    if (!fs::exists(folder / kManifest, ignored))
        return user_error(fmt::format(messages::kNotAFolderOfSlices, folder.string()));
    const Result<std::string> text = read_file(folder / kManifest, raster::kMostManifestBytes);
    if (!text) return text.error();
    const Result<JsonValue> manifest = read_note(folder / kManifest);
    if (!manifest) return manifest.error();
    if (!is_true(*manifest, "complete"))
        return user_error(fmt::format(messages::kFolderNotFinished, folder.string()));
    const raster::Digests digests = raster::manifest_digests(*text);
    // Both are written together: one without the other has been changed.
    if (digests.empty() && fs::exists(folder / raster::kDigestFile, ignored))
        return user_error(
            fmt::format(messages::kManifestWithoutDigests, folder.string(), raster::kDigestFile));
    const FolderFiles files = look_for_files(folder, *manifest);
    std::vector<std::string> wrong = wrong_files(folder, files, *text);
    if (files.names.empty()) wrong.push_back(fmt::format(messages::kFileDiffers, kManifest));
    if (!wrong.empty()) {
        constexpr size_t kMost = 5;
        const size_t more = wrong.size() - std::min(wrong.size(), kMost);
        wrong.resize(wrong.size() - more);
        return user_error(
            fmt::format(messages::kFilesNotAsWritten, folder.string(), fmt::join(wrong, ", "),
                        more == 0 ? std::string() : fmt::format(messages::kAndMoreFiles, more)));
    }
    const bool grey = text_of(*manifest, "color_mode").starts_with("grey");
    const std::string recorded = text_of(*manifest, "hash");
    if (!grey) {
        const Result<std::unique_ptr<prints::PrintFile>> print =
            prints::PrintFile::open(folder.string(), memory_bytes);
        // Colours of materials that are alike do not tell the voxels, either.
        if (!print && digests.empty()) return print.error();
        if (print) {
            const Result<uint64_t> hash = (*print)->hash_of_slices();
            if (!hash) return hash.error();
            if (fmt::format("{:016x}", *hash) != recorded) {
                return user_error(
                    fmt::format(messages::kHashDiffers, folder.string(), *hash, recorded));
            }
        }
    } else if (digests.empty()) {
        return user_error(fmt::format(messages::kNothingToCheckBy, folder.string()));
    }
    say(fmt::format(messages::kAllFilesWhole, printable(folder.string()), files.names.size(),
                    number_of(*manifest, "slices"),
                    digests.empty() ? messages::kWithoutDigests : "", recorded));
    return {};
}

namespace {

/// An .npy file and what the text beside it says.
struct ArrayFile {
    InputFile file;
    JsonValue note;
    std::vector<int64_t> shape;
    bool fractions = false;
    int64_t value_bytes = 1;
    size_t materials = 0;
};

Error array_error(const std::string& file, const std::string& what) {
    return user_error(
        fmt::format(messages::kArrayDamaged, file, raster::array_json_path(file), what));
}

Result<ArrayFile> open_array(const std::string& name) {
    Result<InputFile> file = InputFile::open(name);
    if (!file) return with_context(file.error(), fmt::format(messages::kCannotReadFile, name));
    const std::string beside = raster::array_json_path(name);
    std::error_code ignored;
    if (!fs::exists(beside, ignored))
        return user_error(fmt::format(messages::kArrayWithoutNote, name, beside));
    Result<JsonValue> note = read_note(beside);
    if (!note) return note.error();
    ArrayFile array{std::move(*file), std::move(*note), {}};
    if (!is_true(array.note, "complete")) return array_error(name, messages::kArrayNotFinished);
    const JsonValue* const shape = member_of(array.note, "shape_zyx");
    const JsonValue* const materials = member_of(array.note, "materials");
    if (shape == nullptr || shape->items.size() != 3 || materials == nullptr ||
        !materials->is(JsonValue::Kind::kArray))
        return user_error(fmt::format(messages::kFolderDamaged, beside));
    for (const JsonValue& size : shape->items)
        array.shape.push_back(size.whole().value_or(0));
    array.materials = materials->items.size();
    std::vector<uint8_t> header(raster::kNpyHeaderBytes);
    const Result<size_t> read = array.file.read(0, header.data(), header.size());
    if (!read) return read.error();
    header.resize(*read);
    array.fractions = header != raster::npy_header("|u1", array.shape);
    if (array.fractions) {
        // Fractions are of the parts' materials: all, or all but that of the support.
        for (const size_t count : {array.materials, array.materials - 1}) {
            std::vector<int64_t> shape4 = array.shape;
            shape4.push_back(static_cast<int64_t>(count));
            if (header != raster::npy_header("<f4", shape4)) continue;
            array.shape = shape4;
            array.value_bytes = sizeof(float);
        }
        if (array.value_bytes == 1) return array_error(name, messages::kArrayHeader);
    }
    int64_t bytes = array.value_bytes;
    for (const int64_t size : array.shape)
        bytes *= size;
    bytes += static_cast<int64_t>(raster::kNpyHeaderBytes);
    if (array.file.bytes() != bytes)
        return array_error(name, fmt::format(messages::kArrayBytes, array.file.bytes(), bytes));
    return array;
}

/// Calls `visit` with each slice of the array.
template <typename Visit>
Result<void> each_slice(const ArrayFile& array, const std::string& name, const Visit& visit) {
    int64_t bytes = array.value_bytes;
    for (size_t axis = 1; axis < array.shape.size(); ++axis)
        bytes *= array.shape[axis];
    std::vector<uint8_t> slice(static_cast<size_t>(bytes));
    for (int64_t z = 0; z < array.shape[0]; ++z) {
        const Result<size_t> read = array.file.read(
            static_cast<int64_t>(raster::kNpyHeaderBytes) + z * bytes, slice.data(), slice.size());
        if (!read) return with_context(read.error(), fmt::format(messages::kCannotReadFile, name));
        if (*read != slice.size())
            return array_error(name, fmt::format(messages::kArrayBytes, array.file.bytes(),
                                                 array.file.bytes() + bytes));
        if (Result<void> done = visit(z, slice); !done) return done;
    }
    return {};
}

Result<uint64_t> hash_of_codes(const ArrayFile& array, const std::string& name) {
    const int32_t bits = abi::voxel_bits(static_cast<int32_t>(array.materials));
    const auto height = static_cast<size_t>(array.shape[1]);
    const auto width = static_cast<size_t>(array.shape[2]);
    const size_t row_bytes = backends::packed_row_bytes(static_cast<int32_t>(width), bits);
    std::vector<uint8_t> rows(row_bytes * height);
    uint64_t hash = 0;
    const int64_t first = number_of(array.note, "first_slice_z");
    const Result<void> done =
        each_slice(array, name, [&](int64_t z, const std::vector<uint8_t>& codes) -> Result<void> {
            std::fill(rows.begin(), rows.end(), uint8_t{0});
            for (size_t i = 0; i < codes.size(); ++i) {
                if (codes[i] > array.materials) return array_error(name, messages::kArrayCode);
                const size_t x = i % width;
                uint8_t& to = rows[i / width * row_bytes + (bits == 8 ? x : x / 2)];
                to = static_cast<uint8_t>(to | codes[i] << (bits == 8 || x % 2 == 0 ? 0 : 4));
            }
            hash += pipeline::slice_hash(static_cast<int32_t>(first + z), rows.data(), row_bytes,
                                         static_cast<int32_t>(height));
            return {};
        });
    if (!done) return done.error();
    return hash;
}

Result<uint64_t> hash_of_fractions(const ArrayFile& array, const std::string& name) {
    uint64_t hash = 0;
    const auto materials = static_cast<size_t>(array.shape[3]);
    const int64_t voxels = array.shape[1] * array.shape[2];
    const Result<void> done =
        each_slice(array, name, [&](int64_t z, const std::vector<uint8_t>& bytes) -> Result<void> {
            hash += raster::fractions_hash(
                {reinterpret_cast<const float*>(bytes.data()), bytes.size() / sizeof(float)},
                materials, z * voxels);
            return {};
        });
    if (!done) return done.error();
    return hash;
}

}  // namespace

Result<void> verify_array(const std::string& file) {
    const Result<ArrayFile> array = open_array(file);
    if (!array) return array.error();
    const Result<uint64_t> hash =
        array->fractions ? hash_of_fractions(*array, file) : hash_of_codes(*array, file);
    if (!hash) return hash.error();
    const std::string recorded = text_of(array->note, array->fractions ? "fractions_hash" : "hash");
    if (fmt::format("{:016x}", *hash) != recorded)
        return user_error(fmt::format(messages::kHashDiffers, file, *hash, recorded));
    say(fmt::format(messages::kArrayWhole, printable(file), array->shape[0], recorded));
    return {};
}

namespace {

/// Mirrors packed rows.
void flip_rows(const pipeline::PrintInfo& info, size_t row_bytes, std::vector<uint8_t>* rows) {
    std::vector<uint8_t> codes(static_cast<size_t>(info.size.x));
    for (size_t y = 0; y < static_cast<size_t>(info.size.y); ++y) {
        uint8_t* const row = rows->data() + y * row_bytes;
        for (size_t x = 0; x < codes.size(); ++x) {
            const uint8_t byte = row[info.bits == 8 ? x : x / 2];
            codes[x] = info.bits == 8 ? byte : x % 2 == 0 ? byte & 0xF : byte >> 4;
        }
        std::reverse(codes.begin(), codes.end());
        backends::pack_row(codes, info.bits, row);
    }
}

/// Checks the slices of a package by the hash that it has of them.
Result<void> verify_slices(const prints::PrintFile& print, size_t parts) {
    const pipeline::PrintInfo& info = print.info();
    if (print.whole_slices() < info.size.z) {
        return user_error(fmt::format(messages::kPackageLacksSlice, print.path(),
                                      print.whole_slices(), info.size.z));
    }
    const auto note = print.note();
    uint64_t hash = 0;
    prints::SliceBuffers buffers;
    for (int32_t z = 0; z < info.size.z; ++z) {
        if (Result<void> read = print.read_slice(z, &buffers); !read) return read;
        if (!note) continue;
        if (note->flipped_x) flip_rows(info, print.row_bytes(), &buffers.rows);
        hash += pipeline::slice_hash(note->slice_begin + z, buffers.rows.data(), print.row_bytes(),
                                     info.size.y);
    }
    if (!note) {
        say(fmt::format(messages::kPackageWhole, printable(print.path()), parts));
        return {};
    }
    if (hash != note->hash) {
        return user_error(fmt::format(messages::kHashDiffers, print.path(), hash,
                                      fmt::format("{:016x}", note->hash)));
    }
    say(fmt::format(messages::kPackageSlicesWhole, printable(print.path()), parts, info.size.z,
                    hash));
    return {};
}

}  // namespace

Result<void> verify_package(const std::string& file, int64_t memory_bytes) {
    const Result<std::string> bytes = read_file(file, memory_bytes);
    if (!bytes) return bytes.error();
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(*bytes, file);
    if (!zip) return zip.error();
    const std::vector<std::string> names = zip->names();
    for (const std::string& name : names) {
        const Result<std::string> part = zip->read(name, memory_bytes);
        if (!part) return part.error();
    }
    // Nothing missing is damaged: a package has to be one.
    if (prints::is_gcvf(file)) {
        const Result<std::unique_ptr<prints::PrintFile>> print =
            prints::PrintFile::open(file, memory_bytes);
        if (!print) return print.error();
        return verify_slices(**print, names.size());
    } else if (std::ranges::none_of(names, [](const std::string& name) {
                   return lower_ascii(name).ends_with(".model");
               })) {
        return user_error(fmt::format(messages::kPackageWithoutModel, file));
    }
    say(fmt::format(messages::kPackageWhole, printable(file), names.size()));
    return {};
}

}  // namespace openfab::tools
