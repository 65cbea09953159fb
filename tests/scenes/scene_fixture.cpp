// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/scenes/scene_fixture.h"

#include <rapidjson/document.h>
#include <rapidjson/pointer.h>

#include <regex>

#include "backends/ofr/ofr_reader.h"

namespace openfab::testing {

ScratchFolder* PostcardScene::scratch_ = nullptr;

Voxels read_ofr(const std::filesystem::path& file) {
    Voxels voxels;
    auto reader = ofr::OfrReader::open(file.string());
    if (!reader) {
        ADD_FAILURE() << reader.error().text();
        return voxels;
    }
    const pipeline::PrintInfo& info = (*reader)->info();
    voxels.size = info.size;
    voxels.pitch_mm = info.pitch_mm;
    voxels.origin_mm = info.origin_mm;
    voxels.slice_begin = info.slice_begin;
    voxels.slice_end = info.slice_end;
    for (const pipeline::SliceMaterial& material : info.materials)
        voxels.materials.push_back(material.name);
    for (;;) {
        Result<bool> more = (*reader)->next();
        if (!more) {
            ADD_FAILURE() << more.error().text();
            return voxels;
        }
        if (!*more) return voxels;
        const pipeline::SliceView& slice = (*reader)->slice();
        for (int32_t y = 0; y < info.size.y; ++y) {
            for (int32_t x = 0; x < info.size.x; ++x)
                voxels.codes.push_back(slice.code(x, y, info.bits));
        }
    }
}

double statistic(const std::filesystem::path& file, const std::string& name) {
    const std::string text = read_file(file);
    rapidjson::Document document;
    document.Parse(text.c_str());
    const rapidjson::Value* value =
        document.HasParseError() ? nullptr : rapidjson::Pointer(("/" + name).c_str()).Get(document);
    if (value == nullptr || !value->IsNumber()) {
        ADD_FAILURE() << "no number `" << name << "` in " << file << ": " << text;
        return 0;
    }
    return value->GetDouble();
}

int64_t least_memory_mb(const Outcome& refused) {
    static const std::regex kLeast("too small: this print needs at least ([0-9]+) MB");
    std::smatch match;
    const bool found = std::regex_search(refused.err, match, kLeast);
    EXPECT_TRUE(found) << refused.err;
    EXPECT_NE(refused.exit_code, 0);
    return found ? std::stoll(match[1]) : 0;
}

void PostcardScene::SetUpTestSuite() {
    scratch_ = new ScratchFolder;
}

void PostcardScene::TearDownTestSuite() {
    delete scratch_;
    scratch_ = nullptr;
}

std::filesystem::path PostcardScene::binary() {
    return print_program("postcard");
}

RunOptions PostcardScene::environment() {
    // The cache belongs to the test; the texture helper is the one just built.
    return {{{"OPENFAB_CACHE", (scratch() / "cache").string()},
             {"OPENFAB_HELPER", program("openfab").string()}},
            {},
            {}};
}

Outcome PostcardScene::print(const std::vector<std::string>& arguments) {
    std::vector<std::string> argv{binary().string(),
                                  (gallery_postcard() / "postcard.fab.json").string()};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    return run(argv, environment());
}

}  // namespace openfab::testing
