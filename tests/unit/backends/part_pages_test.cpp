// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What the tables of formats, effects and meshes list has a page beside its code, which names it.

#include <gmock/gmock.h>

#include <cctype>
#include <filesystem>
#include <sstream>
#include <string>

#include "backends/formats/formats.h"
#include "base/json.h"
#include "mesh/load/load_mesh.h"
#include "runtime/process/kinds/kinds.h"
#include "tests/support/places/places.h"

namespace openfab {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;

/// The text of the pages of parts below a folder.
std::string pages_below(const char* folder) {
    std::string text;
    for (const fs::directory_entry& entry :
         fs::recursive_directory_iterator(testing::source_dir() / folder)) {
        if (entry.path().extension() != ".md") continue;
        const Result<std::string> page = read_text_file(entry.path(), 1'000'000);
        if (page) text += *page;
    }
    return text;
}

TEST(PagesOfParts, EachFormatIsOnOne) {
    const std::string pages = pages_below("backends");
    for (const backends::Format* format : backends::formats())
        EXPECT_THAT(pages, HasSubstr("`" + std::string(format->name) + "`"));
}

TEST(PagesOfParts, EachEffectIsOnOne) {
    const std::string pages = pages_below("runtime/process");
    for (const process::Kind* kind : process::kinds())
        EXPECT_THAT(pages, HasSubstr("`" + std::string(kind->key) + "`"));
}

TEST(PagesOfParts, EachKindOfSolidIsOnOne) {
    for (const char* kind : {"beams", "grow", "shape"})
        EXPECT_THAT(pages_below((std::string("runtime/solid/") + kind).c_str()),
                    HasSubstr("\"" + std::string(kind) + "\": "));
}

TEST(PagesOfParts, EachMeshFileIsOnOneWithItsKeys) {
    const std::string page = pages_below("core/mesh/read");
    std::istringstream formats(mesh::mesh_formats());
    for (std::string name; formats >> name;) {
        name = name.substr(1, name.find(',') - 1);
        const std::string small = "`." + name + "`";
        for (char& c : name)
            c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        EXPECT_THAT(page, AnyOf(HasSubstr(name), HasSubstr(small)));
    }
    for (const char* key :
         {"file", "unit", "up", "body", "origin_mm", "groups", "groups_attribute"})
        EXPECT_THAT(page, HasSubstr("| `" + std::string(key) + "` |"));
}

TEST(PagesOfParts, EachHasAPictureAndAnExample) {
    for (const char* folder : {"backends", "runtime/process", "runtime/solid", "core/mesh/read"}) {
        for (const fs::directory_entry& entry :
             fs::recursive_directory_iterator(testing::source_dir() / folder)) {
            if (entry.path().filename() != "README.md") continue;
            const Result<std::string> page = read_text_file(entry.path(), 1'000'000);
            ASSERT_TRUE(page);
            EXPECT_THAT(*page, AllOf(HasSubstr("!["), HasSubstr("```sh\nopenfab ")))
                << entry.path();
        }
    }
}

}  // namespace
}  // namespace openfab
