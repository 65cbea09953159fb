// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_beams.h"

#include <fmt/format.h>

#include <set>

#include "base/near_miss.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_build.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

namespace {

class LatticeReader {
  public:
    LatticeReader(ZipFile zip, std::string file, int64_t memory_bytes)
        : zip_(std::move(zip)), file_(std::move(file)), memory_bytes_(memory_bytes) {}

    Result<ReadThreemfBeams> read() {
        ThreemfBuild build(zip_, file_, &memory_bytes_, &told_);
        const Result<const ThreemfModel*> root = build.root();
        if (!root) return root.error();
        out_.unit_mm = (*root)->unit_mm;
        const Result<void> placed =
            build.each([&](const ThreemfPlaced& one) -> Result<void> { return take(one); });
        if (!placed) return placed.error();
        out_.left_out = std::move(told_.list());
        return std::move(out_);
    }

  private:
    Result<void> take(const ThreemfPlaced& one) {
        const ThreemfObject& object = *one.object;
        out_.has_meshes |= !object.triangles.empty() && object.type == "model";
        if (object.lattice == nullptr) return {};
        if (object.type != "model") {
            told_.add(fmt::format(messages::kLatticesOfType, object.type.substr(0, 40)),
                      lattice_place(one.name), messages::kObjectTypeHelp);
            return {};
        }
        Result<ThreemfBeams> made =
            lattice_beams(object, one.map, one.name, file_, &memory_bytes_, &told_);
        if (!made) return made.error();
        made->name = unique(one.name);
        if (!made->beams.beams.empty()) out_.lattices.push_back(std::move(*made));
        return {};
    }

    std::string unique(const std::string& name) {
        const std::string first = name.empty() ? "lattice" : name;
        std::string made = first;
        for (int k = 2; !names_.insert(made).second; ++k)
            made = fmt::format("{} {}", first, k);
        return made;
    }

    ZipFile zip_;
    std::string file_;
    int64_t memory_bytes_;
    ThreemfTold told_;
    ReadThreemfBeams out_;
    std::set<std::string> names_;
};

/// Adds the beams of one lattice to those of others; attributes that only some have are 0 elsewhere.
void append(const ThreemfBeams& from, Beams* to) {
    const auto first = static_cast<int32_t>(to->nodes.size());
    to->nodes.insert(to->nodes.end(), from.beams.nodes.begin(), from.beams.nodes.end());
    const size_t before = to->beams.size();
    for (Beam beam : from.beams.beams) {
        for (int32_t& node : beam.nodes)
            node += first;
        to->beams.push_back(beam);
    }
    if (!from.beams.attributes.empty() && to->attributes.empty())
        to->attributes.push_back({"set", true, 1, {}, std::vector<int32_t>(before, 0)});
    if (to->attributes.empty()) return;
    std::vector<int32_t>& numbers = to->attributes[0].ints;
    if (!from.beams.attributes.empty()) {
        const std::vector<int32_t>& more = from.beams.attributes[0].ints;
        numbers.insert(numbers.end(), more.begin(), more.end());
    }
    numbers.resize(to->beams.size(), 0);
}

}  // namespace

Result<ReadThreemfBeams> parse_threemf_beams(std::string_view bytes, const std::string& file,
                                             int64_t memory_bytes) {
    Result<ZipFile> zip = ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    return LatticeReader(std::move(*zip), file, memory_bytes).read();
}

Result<ReadBeams> parse_threemf_beams(std::string_view bytes, const std::string& file,
                                      const std::string& body, int64_t memory_bytes) {
    Result<ReadThreemfBeams> read = parse_threemf_beams(bytes, file, memory_bytes);
    if (!read) return read.error();
    if (read->lattices.empty())
        return user_error(fmt::format(messages::kNoLatticePlaced, file),
                          messages::kNoLatticePlacedHelp);
    ReadBeams out;
    out.unit_mm = read->unit_mm;
    for (const LeftOut& left : read->left_out)
        out.warnings.push_back(file + ": " + describe(left));
    std::vector<std::string> names;
    for (const ThreemfBeams& one : read->lattices) {
        names.push_back(one.name);
        if (body.empty() || one.name == body) append(one, &out.beams);
    }
    if (out.beams.beams.empty())
        return user_error(fmt::format(messages::kNoLatticeOfName, file, body.substr(0, 80)),
                          suggest(body.substr(0, 80), names));
    return out;
}

}  // namespace openfab::mesh
