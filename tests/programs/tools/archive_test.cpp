// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab archive`: a print is made again from what the archive holds, in another folder, after its inputs are gone.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "backends/common/output_file.h"
#include "backends/common/package.h"
#include "base/json_text.h"
#include "base/sha256.h"
#include "mesh/read/messages.h"
#include "mesh/read/zip_file.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"
#include "tools/openfab/archive.h"
#include "tools/openfab/messages.h"
#include "world/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;
namespace says_of = tools::messages;

constexpr const char* kObjects[] = {"mesh", "shape", "beams", "grown", "cut", "drawn", "scanned"};

class ArchiveCommand : public OpenfabPrint {
  protected:
    ArchiveCommand() {
        for (const char* folder : {"work/worlds/sub", "work/data", "elsewhere"})
            fs::create_directories(scratch_ / folder);
        scratch_.write("work/data/block.obj", read_file(path("block.obj")));
        scratch_.write("work/data/truss.txt", "node 1 1 1 0.6\nnode 4 3 2 0.4\nstrut 0 1\n");
        scratch_.write("work/data/cut.json", R"({"normal": [1, 0, 0], "at_mm": 1.3})");
        scratch_.write("work/data/picture.pgm", "P5 2 2 255\nabcd");
        scratch_.write("work/data/scan.nhdr",
                       "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 2 2 2\n"
                       "encoding: raw\ndata file: scan.raw\n");
        scratch_.write("work/data/scan.raw", "\x10\x30\x50\x70\x90\xb0\xd0\xf0");
        // A module of a module, and one that only a comment names.
        scratch_.write("work/worlds/inner.fl", "const float THIRD = 0.34;\n");
        scratch_.write(
            "work/worlds/mix.fl",
            "import inner;\nMaterialComposition half(float t, Material a, Material b) {\n"
            "    MaterialComposition mc;\n    mc.Set(a, THIRD + 0.5 * t);\n"
            "    mc.Set(b, 0.66 - 0.5 * t);\n    return mc;\n}\n");
        scratch_.write("work/worlds/unused.fl", "const float UNUSED = 1;\n");
        scratch_.write("work/worlds/all.fl", R"(import mix;
import solids;
fablet Mixed {
    @uniform { float t = 0.1; Material a, b; }
    @Volume(@varying { VolumeAttributes attr }) { return half(t, a, b); }
}
fablet Shaped {
    @uniform { float t = 0.1; Material a, b; }
    @Shape(@varying { ShapeAttributes attr }) [[ distance ]] { return length(attr.p) - 1.5; }
    @Volume(@varying { VolumeAttributes attr }) { return half(t, a, b); }
}
struct Node { float3 end[2]; float radius[2]; int children; float reach; };
fablet Grown {
    @uniform { float t = 0.1; Material a, b; }
    @Grow(@varying { GrowAttributes attr, Node parent }) {
        Node n;
        n.end[0] = float3(0, 0, 1);
        n.end[1] = float3(2, 0, 1);
        n.radius[0] = 0.7;
        n.radius[1] = 0.5;
        n.children = 0;
        n.reach = 0;
        return n;
    }
    @Volume(@varying { VolumeAttributes attr }) { return half(t, a, b); }
}
fablet Drawn {
    @uniform { ImageTexture2D picture; Material a, b; }
    @Volume(@varying { VolumeAttributes attr }) {
        return half(picture.Sample1(attr.voxelCenter.xy, 0), a, b);
    }
}
fablet Scanned {
    @uniform { ImageTexture3D scan; Material a, b; }
    @Volume(@varying { VolumeAttributes attr }) {
        return half(scan.Sample1(attr.voxelCenter, 0), a, b);
    }
}
)");
    }
    /// Writes the world of these objects; textures lie above its folder.
    void write_world(const std::vector<std::string>& names, const std::string& more = "") const {
        const std::map<std::string, std::pair<std::string, std::string>> all{
            {"mesh", {"block", R"("fablet": "mixed")"}},
            {"shape", {"ball", R"("fablet": "shaped")"}},
            {"beams", {"truss", R"("fablet": "mixed")"}},
            {"grown", {"twig", R"("fablet": "grown")"}},
            {"cut", {"block", R"("fablet": "mixed", "pieces": "../data/cut.json")"}},
            {"drawn", {"block", R"("fablet": "drawn")"}},
            {"scanned", {"block", R"("fablet": "scanned")"}},
            {"program", {"answered", R"("fablet": "mixed")"}}};
        std::string objects, build;
        for (const std::string& name : names) {
            const auto& [mesh, rest] = all.at(name);
            const std::string texture = name == "drawn"     ? R"(, "picture": "picture")"
                                        : name == "scanned" ? R"(, "scan": "scan")"
                                                            : "";
            objects += fmt::format(
                R"({}"{}": {{"mesh": "{}", {}, "uniforms": {{"a": "red", "b": "blue"{}}}}})",
                objects.empty() ? "" : ",\n", name, mesh, rest, texture);
            build += fmt::format(R"({}{{"object": "{}", "translate_mm": [{}, 0, 2]{}}})",
                                 build.empty() ? "" : ", ", name, build.size() / 4,
                                 name == "cut" ? R"(, "piece": "1")" : "");
        }
        scratch_.write("work/worlds/all.fab.json", fmt::format(R"({{
"openfab": 1, "printer": "generic",
"fablets": {{"mixed": {{"source": "all.fl", "fablet": "Mixed"}}, "shaped": {{"source": "all.fl", "fablet": "Shaped"}},
  "grown": {{"source": "all.fl", "fablet": "Grown"}}, "drawn": {{"source": "all.fl", "fablet": "Drawn"}},
  "scanned": {{"source": "all.fl", "fablet": "Scanned"}}}},
"materials": {{"red": {{"key": "#ff0000"}}, "blue": {{"key": "#0000ff"}}}},
"textures": {{"picture": {{"file": "../data/picture.pgm"}}, "scan": {{"file": "../data/scan.nhdr"}}}},
"meshes": {{"block": {{"file": "../data/block.obj", "unit": "mm"}}, "ball": {{"shape": "shaped", "box_mm": [[-2, -2, -2], [2, 2, 2]]}},
  "truss": {{"beams": "../data/truss.txt"}}, "twig": {{"grow": "grown", "box_mm": [[-1, -1, 0], [3, 1, 2]]}}{}}},
"objects": {{{}}},
"build": [{}]
}}
)",
                                                               more, objects, build));
    }
    /// Prints from the folder of the world.
    Outcome print_all(const std::string& out, std::vector<std::string> more = {}) const {
        more.insert(more.begin(),
                    {program("openfab"), "print", "worlds/all.fab.json", "-o", path(out), "--allow",
                     "data", "--threads", "2", "--progress", "none", "--voxel", "0.25mm"});
        RunOptions options;
        options.environment = {{"OPENFAB_CACHE", path("cache")}};
        options.folder = scratch_ / "work";
        return run(more, options);
    }
    Outcome archive(const std::vector<std::string>& words) const {
        std::vector<std::string> argv{program("openfab"), "archive"};
        argv.insert(argv.end(), words.begin(), words.end());
        RunOptions options;
        options.environment = {{"OPENFAB_CACHE", path("cache")}};
        options.folder = scratch_ / "elsewhere";
        return run(argv, options);
    }
    std::string hash_of(const std::string& out) const {
        const Outcome shown = run({program("openfab"), "info", path(out)});
        const size_t at = shown.out.find("\nhash ");
        const size_t end = shown.out.find('\n', at + 1);
        return at == std::string::npos ? "" : shown.out.substr(end - 16, 16);
    }
    /// Removes all that the print was made from.
    void forget_inputs() const { fs::remove_all(scratch_ / "work"); }

    /// Writes a ZIP of these entries.
    void write_zip(const std::string& name,
                   const std::vector<std::pair<std::string, std::string>>& entries) const {
        Result<backends::OutputFile> file = backends::OutputFile::create(path(name));
        ASSERT_TRUE(file);
        auto package = backends::Package::create(&*file);
        ASSERT_TRUE(package);
        for (const auto& [entry, text] : entries)
            ASSERT_TRUE((*package)->add(entry, text));
        ASSERT_TRUE((*package)->close());
        ASSERT_TRUE(file->close());
    }
};

TEST_F(ArchiveCommand, PrintsEveryKindOfInputAgain) {
    write_world({kObjects, kObjects + std::size(kObjects)});
    scratch_.write("work/mine.printer.json", R"({"name": "mine", "pitch_mm": [0.2, 0.2, 0.25],
"build_volume_mm": [100, 100, 100], "max_materials": 8, "native_format": "ofr", "makes_support": true,
"handoff": "as it is"})");
    scratch_.write("work/process.json", R"({"scale": 1.01})");
    const Outcome made =
        print_all("a.ofr", {"--printer", "mine.printer.json", "--process", "process.json", "--set",
                            "mesh.t=0.3", "--part", "2/2", "--dither=floyd_steinberg"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    scratch_.write("report.json", R"({"holds": true})");
    const Outcome kept = archive({path("a.ofr"), "-o", path("a.zip"), "--attach",
                                  path("report.json"), "--operator", "A. Lovelace <x>"});
    ASSERT_EQ(kept.exit_code, 0) << kept.err;
    const std::string hash = hash_of("a.ofr");
    ASSERT_EQ(hash.size(), 16U);
    forget_inputs();
    const Outcome again = archive({"--reprint", path("a.zip"), "-o", path("b.ofr")});
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_THAT(again.out, Says(says_of::kReprintSame, "*", hash));
    EXPECT_EQ(hash_of("b.ofr"), hash);
    EXPECT_EQ(read_file(path("a.ofr")), read_file(path("b.ofr")));

    const std::string bytes = read_file(path("a.zip"));
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "a.zip");
    ASSERT_TRUE(zip) << zip.error().text();
    std::string names;
    for (const std::string& name : zip->names())
        names += name + "\n";
    for (const char* name :
         {"files/worlds/all.fab.json", "files/worlds/all.fl", "files/worlds/mix.fl",
          "files/worlds/inner.fl", "files/data/block.obj", "files/data/truss.txt",
          "files/data/cut.json", "files/data/picture.pgm", "files/data/scan.nhdr",
          "files/data/scan.raw", "files/mine.printer.json", "files/process.json",
          "attached/report.json"})
        EXPECT_THAT(names, HasSubstr(name));
    EXPECT_THAT(names, Not(HasSubstr("unused")));
    // The page has the digests, and what people typed is no markup.
    const Result<std::string> page = zip->read("record.html"), json = zip->read("archive.json");
    ASSERT_TRUE(page && json);
    EXPECT_THAT(*page, HasSubstr(hash));
    EXPECT_THAT(*page, HasSubstr(hex_text(sha256(read_file(path("report.json"))))));
    EXPECT_THAT(*page, HasSubstr(hex_text(sha256(*json))));
    EXPECT_THAT(*page, HasSubstr("A. Lovelace &lt;x&gt;"));
    // The same archive, whenever it is made. (The inputs are gone: it is made from a copy.)
    EXPECT_EQ(archive({path("a.ofr"), "-o", path("c.zip")}).exit_code, 1);
}

TEST_F(ArchiveCommand, KeepsFoldersOfSlicesAndProjects) {
    write_world({"mesh"});
    scratch_.write("work/openfab.project", "");
    fs::rename(scratch_ / "work/worlds/all.fab.json", scratch_ / "work/worlds/sub/all.fab.json");
    fs::copy(scratch_ / "work/worlds/all.fl", scratch_ / "work/worlds/sub/all.fl");
    for (const char* module : {"mix.fl", "inner.fl"})
        fs::copy(scratch_ / "work/worlds" / module, scratch_ / "work/worlds/sub" / module);
    fs::copy(scratch_ / "work/data", scratch_ / "work/worlds/data");
    ASSERT_EQ(print({path("work/worlds/sub/all.fab.json"), "-o", path("slices"), "--format", "png",
                     "--flip-x", "--voxel", "0.25mm"})
                  .exit_code,
              0);
    ASSERT_EQ(archive({path("slices"), "-o", path("a.zip")}).exit_code, 0);
    forget_inputs();
    const Outcome again = archive({"--reprint", path("a.zip"), "-o", path("more")});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(read_file(path("slices/SHA256SUMS")), read_file(path("more/SHA256SUMS")));
    EXPECT_GT(read_file(path("slices/SHA256SUMS")).size(), 0U);
}

TEST_F(ArchiveCommand, KeepsMeshesWithStockFablets) {
    ASSERT_EQ(
        print({path("block.obj"), "--fablet", "solid", "-o", path("a.ofr"), "--voxel", "0.2mm"})
            .exit_code,
        0);
    ASSERT_EQ(archive({path("a.ofr"), "-o", path("a.zip")}).exit_code, 0);
    fs::remove(path("block.obj"));
    const Outcome again = archive({"--reprint", path("a.zip"), "-o", path("b.ofr")});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(hash_of("b.ofr"), hash_of("a.ofr"));
}

TEST_F(ArchiveCommand, RunsProgramsOnlyIfItMay) {
    write_world({"program"},
                R"(, "answered": {"program": ["./answer.sh"], "box_mm": [[0, 0, 0], [4, 4, 4]]})");
    scratch_.write(
        "work/worlds/answer.sh",
        "#!/bin/sh\nwhile read line; do echo beam 1 1 1 3 3 3 0.5 0.5; echo done; done\n");
    fs::permissions(scratch_ / "work/worlds/answer.sh", fs::perms::owner_all);
    const Outcome made = print_all("a.ofr", {"--allow-programs"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const Outcome kept = archive({path("a.ofr"), "-o", path("a.zip")});
    ASSERT_EQ(kept.exit_code, 0) << kept.err;
    EXPECT_THAT(kept.err, Says(says_of::kProgramNotKept, "./answer.sh"));
    forget_inputs();
    const Outcome refused = archive({"--reprint", path("a.zip"), "-o", path("b.ofr")});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, Says(says_of::kReprintRunsPrograms));
    const Outcome again =
        archive({"--reprint", path("a.zip"), "-o", path("b.ofr"), "--allow-programs"});
    EXPECT_EQ(again.exit_code, 0) << again.err;
}

TEST_F(ArchiveCommand, RefusesWhatItCannotKeep) {
    write_world({"mesh"});
    EXPECT_THAT(archive({path("none.ofr"), "-o", path("a.zip")}).err,
                Says(says_of::kNothingToArchive, "*"));
    ASSERT_EQ(print_all("a.ofr").exit_code, 0);
    // A changed input, also one that only a module imports, and one that is gone.
    for (const char* name : {"work/data/block.obj", "work/worlds/inner.fl"}) {
        const std::string before = read_file(path(name));
        scratch_.write(name, before + "\n");
        const Outcome changed = archive({path("a.ofr"), "-o", path("a.zip")});
        EXPECT_EQ(changed.exit_code, 1);
        EXPECT_THAT(changed.err, HasSubstr(fs::path(name).filename().string()));
        EXPECT_THAT(changed.err, Says(says_of::kInputsChanged, "*"));
        EXPECT_FALSE(fs::exists(path("a.zip")));
        scratch_.write(name, before);
    }
    EXPECT_EQ(archive({path("a.ofr"), "-o", path("a.zip")}).exit_code, 0);
    // An input is not overwritten.
    EXPECT_THAT(archive({path("a.ofr"), "-o", path("work/data/block.obj")}).err,
                Says(says_of::kArchiveOverInput, "*"));
    // Another print under the record's name.
    ASSERT_EQ(print_all("b.ofr", {"--seed", "3"}).exit_code, 0);
    fs::copy(path("b.ofr"), path("a.ofr"), fs::copy_options::overwrite_existing);
    EXPECT_THAT(archive({path("a.ofr"), "-o", path("b.zip")}).err,
                Says(says_of::kRecordOfOther, "*", "*"));
    fs::remove(path("a.ofr.job.json"));
    EXPECT_THAT(archive({path("a.ofr"), "-o", path("b.zip")}).err,
                Says(says_of::kNoRecordBeside, "*", "*"));
    // A path that leads there on this machine only.
    write_world({"mesh"}, fmt::format(R"(, "other": {{"file": "{}", "unit": "mm"}})",
                                      path("work/data/block.obj")));
    ASSERT_EQ(print_all("c.ofr").exit_code, 0);
    EXPECT_THAT(archive({path("c.ofr"), "-o", path("c.zip")}).err,
                Says(says_of::kNamedAbsolutely, "*"));
}

TEST_F(ArchiveCommand, SaysWhatDiffers) {
    write_world({"mesh"});
    ASSERT_EQ(print_all("a.ofr").exit_code, 0);
    ASSERT_EQ(archive({path("a.ofr"), "-o", path("a.zip")}).exit_code, 0);
    const std::string bytes = read_file(path("a.zip"));
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "a.zip");
    ASSERT_TRUE(zip);
    std::vector<std::pair<std::string, std::string>> entries;
    for (const std::string& name : zip->names())
        entries.emplace_back(name, *zip->read(name));
    const auto with = [&](const std::string& from, const std::string& to) {
        std::vector<std::pair<std::string, std::string>> changed = entries;
        for (auto& [name, text] : changed) {
            if (name != "archive.json") continue;
            const size_t at = text.find(from);
            EXPECT_NE(at, std::string::npos) << from;
            if (at != std::string::npos) text.replace(at, from.size(), to);
        }
        write_zip("b.zip", changed);
        return archive({"--reprint", path("b.zip"), "-o", path("b.ofr")});
    };
    const std::string hash = hash_of("a.ofr"), other(16, '0');
    // An older version gave another hash; the profile was another.
    const size_t at = entries[0].second.find("version of openfab");
    ASSERT_NE(at, std::string::npos) << entries[0].first;
    Outcome outcome = with(hash, other);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err,
                Says(says_of::kReprintDiffers, "*", hash, other, says_of::kNothingKnownDiffers));
    entries[0].second.replace(entries[0].second.find(hash), 16, other);
    outcome = with(R"(["version of openfab",")", R"(["version of openfab","9)");
    EXPECT_THAT(outcome.err, HasSubstr("version of openfab"));
    outcome = with(R"(["meshes",")", R"(["meshes","9)");
    EXPECT_THAT(outcome.err, HasSubstr("meshes"));
    // Words and paths that no archive of ours has.
    outcome = with(R"(["INPUT",")", R"(["--stats",")" + path("stats.json") + R"("],["INPUT",")");
    EXPECT_THAT(outcome.err, Says(says_of::kOptionNotArchived, "--stats"));
    EXPECT_FALSE(fs::exists(path("stats.json")));
    outcome = with(R"(["INPUT",")", R"(["--printer","../../etc/x.printer.json"],["INPUT",")");
    EXPECT_THAT(outcome.err, Says(says_of::kPathNotKept, "--printer", "*"));
    outcome = with(R"("path":"worlds/all.fl")", R"("path":"../../all.fl")");
    EXPECT_THAT(outcome.err, Says(says_of::kArchiveWrong, "*", "path"));
    outcome = with(R"("path":"worlds/all.fl")", R"("path":"/tmp/all.fl")");
    EXPECT_THAT(outcome.err, Says(says_of::kArchiveWrong, "*", "path"));
    outcome = with(R"("path":"worlds/all.fl")", R"("path":"worlds/all.fab.json")");
    EXPECT_THAT(outcome.err, Says(says_of::kArchivedTwice, "*"));
    // A file of the archive that is not what its digest says.
    for (auto& [name, text] : entries) {
        if (name == "files/data/block.obj") text.replace(text.find("v 4"), 3, "v 5");
    }
    outcome = with("openfab.archive", "openfab.archive");
    EXPECT_THAT(outcome.err, Says(says_of::kArchivedFileDiffers, "data/block.obj"));
    EXPECT_EQ(outcome.exit_code, 1);
}

/// The page that a person signs: who reprints is told that it is not the one that was made.
TEST_F(ArchiveCommand, TellsWhereTheRecordWasChanged) {
    write_world({"mesh"});
    ASSERT_EQ(print_all("a.ofr").exit_code, 0);
    ASSERT_EQ(archive({path("a.ofr"), "-o", path("a.zip"), "--operator", "A. Lovelace"}).exit_code,
              0);
    const std::string bytes = read_file(path("a.zip"));
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "a.zip");
    ASSERT_TRUE(zip);
    const auto reprint = [&](const std::function<void(std::string*)>& change) {
        std::vector<std::pair<std::string, std::string>> entries;
        for (const std::string& name : zip->names()) {
            std::string text = *zip->read(name);
            if (name == "record.html") change(&text);
            if (!text.empty()) entries.emplace_back(name, text);
        }
        write_zip("b.zip", entries);
        const Outcome outcome = archive({"--reprint", path("b.zip"), "-o", path("b.ofr")});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err;
    };
    const auto said = Says(says_of::kRecordPageChanged, "*");
    EXPECT_THAT(reprint([](std::string*) {}), Not(said));
    EXPECT_THAT(reprint([](std::string* page) {
                    page->replace(page->find("A. Lovelace"), 11, "C. Babbage ");
                }),
                said);
    // Digests are letters, too.
    const std::string digest = hex_text(sha256(*zip->read("archive.json")));
    EXPECT_THAT(reprint([&](std::string* page) {
                    page->replace(page->find(digest), digest.size(), std::string(64, '0'));
                }),
                said);
    EXPECT_THAT(reprint([](std::string* page) { page->clear(); }), said) << "it is taken out";
}

/// What a stranger's archive may unpack to.
TEST_F(ArchiveCommand, RefusesWhatExpandsWithoutEnd) {
    write_world({"mesh"});
    ASSERT_EQ(print_all("a.ofr").exit_code, 0);
    ASSERT_EQ(archive({path("a.ofr"), "-o", path("a.zip")}).exit_code, 0);
    const std::string bytes = read_file(path("a.zip"));
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "a.zip");
    ASSERT_TRUE(zip);
    const auto reprint = [&](const std::string& rows, const std::string& name,
                             const std::string& content) {
        std::vector<std::pair<std::string, std::string>> entries;
        for (const std::string& each : zip->names()) {
            std::string text = *zip->read(each);
            if (each == "archive.json") text.insert(text.find("\"files\":[") + 9, rows);
            entries.emplace_back(each, text);
        }
        if (!name.empty()) entries.emplace_back(name, content);
        write_zip("b.zip", entries);
        const Outcome outcome = archive({"--reprint", path("b.zip"), "-o", path("b.ofr")});
        EXPECT_FALSE(fs::exists(path("b.ofr")));
        return outcome;
    };
    const auto row = [](const std::string& entry, const std::string& file, int64_t size) {
        return fmt::format(
            R"({{"entry":"{}","path":"{}","bytes":{},"sha256":"{}","executable":false}},)", entry,
            file, size, std::string(64, '0'));
    };
    // Zeros, two thousand times as small.
    const std::string zeros(200'000'000, '\0');
    Outcome outcome = reprint(row("files/zeros", "zeros", 200'000'000), "files/zeros", zeros);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, Says(mesh::messages::kEntryUnpacksTooFar, "*"));
    // One entry as many files, and very many files.
    std::string rows;
    for (int i = 0; i < 3; ++i)
        rows += row("files/zeros", fmt::format("{}", i), 1000);
    outcome = reprint(rows, "files/zeros", std::string(1000, '\0'));
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, Says(says_of::kArchivedTwice, "files/zeros"));
    rows.clear();
    for (int i = 0; i < 100'000; ++i)
        rows += row(fmt::format("files/{}", i), fmt::format("{}", i), 0);
    outcome = reprint(rows, "", "");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, Says(says_of::kArchiveOfManyFiles, "*", "*", "*"));
    // More than any disk has.
    outcome = reprint(row("files/x", "x", 8'000'000'000'000'000), "files/x", "x");
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_THAT(outcome.err, Says(says_of::kNoRoomForArchive, "*", "*", "*", "*"));
}

/// Else an archive refuses prints with a new option, or keeps what it should not.
TEST_F(ArchiveCommand, KnowsAllOptionsOfPrints) {
    const std::string help = run({program("openfab"), "print", "--help"}).out;
    size_t found = 0;
    for (size_t at = help.find("--"); at != std::string::npos; at = help.find("--", at + 2)) {
        size_t end = at + 2;
        while (end < help.size() && (std::isalnum(help[end]) != 0 || help[end] == '-'))
            ++end;
        if (end == at + 2) continue;
        EXPECT_NE(tools::find_archived_option(help.substr(at, end - at)), nullptr)
            << help.substr(at, end - at);
        ++found;
        at = end - 2;
    }
    EXPECT_GT(found, 40U);
}

}  // namespace
}  // namespace openfab::testing
