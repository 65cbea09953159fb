// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_package.h"

#include <fmt/format.h>

#include "base/input_file.h"
#include "base/xml.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf.h"

namespace openfab::mesh {
namespace {

/// Finds the model and the key store among the package's relationships.
class Relationships : public XmlHandler {
  public:
    std::string model, key_store;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        const char* type = a.find("Type");
        const char* target = a.find("Target");
        if (name != "Relationship" || type == nullptr || target == nullptr) return {};
        const std::string_view kind = type;
        if (model.empty() && kind.ends_with("/3dmodel")) model = target;
        if (key_store.empty() && kind.ends_with("/keystore")) key_store = target;
        return {};
    }
    void end(std::string_view) override {}
};

class KeyStore : public XmlHandler {
  public:
    std::set<std::string> parts;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        constexpr size_t kMost = 10'000;
        const char* path = a.find("path");
        if (name == "resourcedata" && path != nullptr && parts.size() < kMost)
            parts.insert(ZipFile::key(path));
        return {};
    }
    void end(std::string_view) override {}
};

Result<Relationships> parse_relationships(std::string_view text, const std::string& file) {
    Relationships found;
    const Result<void> parsed = parse_xml(text, fmt::format("{}: _rels/.rels", file), &found);
    if (!parsed) return parsed.error();
    if (found.model.empty()) return user_error(fmt::format(messages::kNoModel, file));
    return found;
}

}  // namespace

Result<std::string> ThreemfPackage::read(const ZipFile& zip, const std::string& name,
                                         const std::string& file, int64_t memory_bytes) const {
    if (encrypted.count(ZipFile::key(name)) != 0)
        return user_error(fmt::format(messages::kEncryptedArchive, file, name),
                          messages::kEncryptedArchiveHelp);
    return zip.read(name, memory_bytes);
}

Result<ThreemfPackage> read_threemf_package(const ZipFile& zip, const std::string& file,
                                            int64_t memory_bytes) {
    const Result<std::string> text = zip.read("_rels/.rels", memory_bytes);
    if (!text) return text.error();
    const Result<Relationships> found = parse_relationships(*text, file);
    if (!found) return found.error();
    ThreemfPackage out;
    out.model = found->model;
    if (found->key_store.empty()) return out;
    const Result<std::string> store = zip.read(found->key_store, memory_bytes);
    if (!store) return store.error();
    KeyStore keys;
    const Result<void> parsed =
        parse_xml(*store, fmt::format("{}: {}", file, found->key_store), &keys);
    if (!parsed) return parsed.error();
    out.encrypted = std::move(keys.parts);
    return out;
}

Result<void> read_threemf_pictures(const std::filesystem::path& file,
                                   std::span<const std::string> sources, int64_t memory_bytes,
                                   const TakePicture& take) {
    Result<InputFile> input = InputFile::open(file);
    if (!input) {
        Error error = input.error();
        error.message = fmt::format("{}: {}", file.string(), error.message);
        return error;
    }
    const Result<std::string> bytes = input->read_all(memory_bytes);
    if (!bytes) return bytes.error();
    const Result<ZipFile> zip = ZipFile::open(*bytes, file.string());
    if (!zip) return zip.error();
    const int64_t left = memory_bytes - static_cast<int64_t>(bytes->size());
    const Result<ThreemfPackage> package = read_threemf_package(*zip, file.string(), left);
    if (!package) return package.error();
    for (size_t i = 0; i < sources.size(); ++i)
        take(i, package->read(*zip, sources[i], file.string(), left));
    return Ok{};
}

}  // namespace openfab::mesh
