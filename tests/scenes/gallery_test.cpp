// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Every object of the gallery at a small size: its recorded hash, the same for any number of
// threads, without culling, for every instruction set and under every schedule; and its fablet on
// meshes that it was not written for.

#include <fmt/format.h>
#include <rapidjson/document.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <regex>

#include "abi/kernel_call.h"
#include "runtime/pipeline/messages.h"
#include "tests/scenes/random_schedules.h"
#include "tests/scenes/scene_fixture.h"
#include "tests/support/long_run.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

struct Exhibit {
    const char* folder;
    const char* world;
    const char* program;
    const char* voxel;
    bool only_long = false;  ///< takes a minute to compile: in long runs alone
    bool own_geometry =
        false;  ///< reads what only its own geometry has: rules, beams, a shape's outputs
    std::string name() const { return fmt::format("{}_{}", folder, world); }
};

void PrintTo(const Exhibit& exhibit, std::ostream* out) {
    *out << exhibit.name();
}

constexpr Exhibit kExhibits[] = {
    {"magic_postcard", "postcard", "postcard", "0.5mm"},
    {"magic_postcard", "lighthouse", "postcard", "0.5mm"},
    {"rhino", "spikes", "rhino_spikes", "0.6mm"},
    {"rhino", "holes", "rhino_holes", "0.6mm"},
    {"rhino", "armour", "rhino_armour", "0.6mm"},
    {"amber", "amber", "amber", "0.4mm"},
    {"foam", "bunny", "soft_toy", "0.6mm"},
    {"foam", "bear", "soft_toy", "0.6mm"},
    {"marble_table", "table", "marble_table", "0.7mm"},
    {"microlens_array", "microlens", "microlens_array", "0.25mm"},
    {"anisotropic_blocks", "blocks", "rods", "0.5mm"},
    {"reef_fish", "reef_fish", "reef_fish", "0.5mm"},
    {"gyroid_block", "gyroid", "gyroid_block", "0.4mm"},
    {"gyroid_block", "lattices", "lattices", "0.4mm"},
    {"coupon", "coupon", "coupon", "0.2mm"},
    {"calibration_chart", "chart", "calibration_chart", "0.4mm"},
    {"ink_profile", "cameo", "ink_profile", "0.5mm"},
    {"conformal_wheel", "wheel", "conformal_wheel", "0.6mm"},
    {"library", "fields", "fields", "0.25mm"},
    {"library", "surfaces", "surfaces", "0.25mm", true},
    {"library", "trusses", "trusses", "0.25mm", true},
    {"library", "shapes", "shapes", "0.25mm", true},
    {"library", "harmonics", "harmonics", "0.25mm", true},
    {"library", "patterns", "patterns", "0.25mm"},
    {"library", "textures", "textures", "0.25mm"},
    {"library", "dithers", "dithers", "0.25mm"},
    {"library", "mappings", "mappings", "0.25mm"},
    {"library", "grades", "grades", "0.25mm"},
    {"library", "color_spaces", "color_spaces", "0.25mm"},
    {"library", "inks", "inks", "0.25mm"},
    {"library", "properties", "properties", "0.25mm"},
    {"halftones", "halftones", "halftones", "0.25mm"},
    {"filament_vase", "vase", "filament_vase", "0.4mm"},
    {"bone", "bone", "bone", "1mm"},
    {"insole", "insole", "insole", "0.7mm"},
    {"bracket", "bracket", "bracket", "0.5mm"},
    {"peach", "peach", "peach", "0.5mm"},
    {"tree", "tree", "tree", "0.5mm", false, true},
    {"vessel_tree", "vessels", "vessel_tree", "0.4mm", false, true},
    {"menger_sponge", "menger_sponge", "menger_sponge", "0.4mm", false, true},
    {"bunny_skin", "bunny_skin", "bunny_skin", "0.5mm", false, true},
};

struct Contents {
    std::string hash;
    std::map<std::string, double> voxels;  ///< by material
};

class Gallery : public ::testing::TestWithParam<Exhibit> {
  protected:
    static void TearDownTestSuite() {
        delete scratch_;
        scratch_ = nullptr;
    }
    void SetUp() override {
        if (scratch_ == nullptr) scratch_ = new ScratchFolder;
        const Exhibit& exhibit = GetParam();
        folder_ = source_dir() / "gallery" / exhibit.folder;
        if (!exhibit.only_long) {
            binary_ = print_program(exhibit.program);
            return;
        }
        if (!long_run()) GTEST_SKIP() << "takes a minute to compile";
        binary_ = *scratch_ / exhibit.program;
        if (std::filesystem::exists(binary_)) return;
        const Outcome built =
            run({program("openflc").string(), "build", fablet().string(), "-o", binary_.string()},
                environment());
        ASSERT_EQ(built.exit_code, 0) << built.err;
    }

    std::filesystem::path fablet() const {
        const std::string name = GetParam().program;
        return folder_ / fmt::format("{}.fl", name == "postcard" ? "magic_postcard" : name);
    }

    static RunOptions environment() {
        return {{{"OPENFAB_CACHE", (*scratch_ / "cache").string()},
                 {"OPENFAB_HELPER", program("openfab").string()}},
                {},
                {}};
    }

    Contents print(const std::filesystem::path& world, std::vector<std::string> more = {}) {
        const std::filesystem::path stats = *scratch_ / "stats.json";
        std::vector<std::string> argv{
            binary_.string(), world.string(),   "--printer", "generic",
            "--voxel",        GetParam().voxel, "--stats",   stats.string(),
            "--progress",     "none",           "-o",        (*scratch_ / "print.ofr").string()};
        argv.insert(argv.end(), more.begin(), more.end());
        const Outcome printed = run(argv, environment());
        EXPECT_EQ(printed.exit_code, 0) << world << ": " << printed.err;
        Contents contents;
        if (printed.exit_code != 0) return contents;
        rapidjson::Document document;
        document.Parse(read_file(stats).c_str());
        EXPECT_FALSE(document.HasParseError());
        contents.hash = document["hash"].GetString();
        for (const auto& warning : document["warnings"].GetArray())
            EXPECT_THAT(std::string(warning.GetString()),
                        ::testing::Not(testing::Says(pipeline::messages::kPrintsSlowly)));
        for (const auto& entry : document["voxels_by_material"].GetObject())
            contents.voxels[entry.name.GetString()] = entry.value.GetDouble();
        return contents;
    }

    /// Prints with its own printer; returns the slices of the whole.
    int slices_of(std::vector<std::string> more) {
        const std::filesystem::path stats = *scratch_ / "draft.json";
        std::vector<std::string> argv{binary_.string(), world().string(), "--stats",
                                      stats.string(),   "--progress",     "none"};
        argv.insert(argv.end(), more.begin(), more.end());
        const Outcome printed = run(argv, environment());
        EXPECT_EQ(printed.exit_code, 0) << fmt::format("{}: ", fmt::join(more, " ")) << printed.err;
        if (printed.exit_code != 0) return 0;
        rapidjson::Document document;
        document.Parse(read_file(stats).c_str());
        return document["size_voxels"][2].GetInt();
    }

    std::filesystem::path world() const {
        return folder_ / fmt::format("{}.fab.json", GetParam().world);
    }

    /// The gallery's world with every mesh replaced, where `mesh` is JSON.
    std::filesystem::path world_with(const std::string& mesh) {
        std::string text = read_file(world());
        const std::regex meshes(
            R"x(\{"file": "[^"]*\.obj"[^{}]*(\{[^{}]*\})?\}|\{"box": \[[^\]]*\]\}|\{"shape": [^{}]*\})x");
        text = std::regex_replace(text, meshes, mesh);
        const std::string figures = (source_dir() / "gallery" / "figures").string();
        text = std::regex_replace(text, std::regex(R"x(\.\./figures)x"), figures);
        const std::regex relative(R"x("(file|source)": "([^/"][^"]*)")x");
        text =
            std::regex_replace(text, relative, fmt::format("\"$1\": \"{}/$2\"", folder_.string()));
        scratch_->write("foreign.fab.json", text);
        return *scratch_ / "foreign.fab.json";
    }

    static ScratchFolder* scratch_;
    std::filesystem::path folder_;
    std::filesystem::path binary_;
};

ScratchFolder* Gallery::scratch_ = nullptr;

/// A ring: a body with a hole, which our primitives are not.
std::string ring_obj() {
    constexpr int kAround = 48, kAcross = 24;
    std::string text;
    const auto angle = [](int i, int n) { return 2 * M_PI * i / n; };
    for (int i = 0; i < kAround; ++i) {
        for (int k = 0; k < kAcross; ++k) {
            const double r = 14 + 6.5 * std::cos(angle(k, kAcross));
            text +=
                fmt::format("v {:.4f} {:.4f} {:.4f}\n", r * std::cos(angle(i, kAround)),
                            r * std::sin(angle(i, kAround)), 8 + 6.5 * std::sin(angle(k, kAcross)));
        }
    }
    const auto vertex = [](int i, int k) { return i % kAround * kAcross + k % kAcross + 1; };
    for (int i = 0; i < kAround; ++i) {
        for (int k = 0; k < kAcross; ++k) {
            text += fmt::format("f {} {} {} {}\n", vertex(i, k), vertex(i + 1, k),
                                vertex(i + 1, k + 1), vertex(i, k + 1));
        }
    }
    return text;
}

std::string expected_hash(const std::string& name) {
    std::ifstream in(source_dir() / "tests" / "scenes" / "gallery_hashes.txt");
    std::string key;
    std::string hash;
    while (in >> key >> hash) {
        if (key == name) return hash;
    }
    return "none";
}

// A box that a shape leaves, a part that no pitch shows: whatever stops a draft stops the print, too.
TEST_P(Gallery, PrintsAtEveryDraft) {
    const std::string output = (*scratch_ / "draft.ofr").string();
    for (int draft = 16; draft >= 1; --draft) {
        if (!long_run() && draft % 4 != 0 && draft > 2) continue;
        // Its skin takes above two minutes of processor time to be laid out for these.
        if (!long_run() && draft < 4 && GetParam().folder == std::string("bunny_skin")) continue;
        const std::string number = std::to_string(draft);
        if (long_run() || draft == 16) {
            EXPECT_GT(slices_of({"--draft", number, "-o", output}), 0) << draft;
        } else {
            EXPECT_GT(slices_of({"--draft", number, "--dry-run"}), 0) << draft;
        }
    }
    if (!long_run()) return;
    const int slices = slices_of({"--dry-run"}), middle = slices / 2;
    slices_of({"-o", output, "--slices", fmt::format("{}:{}", middle, middle + 1)});
}

TEST_P(Gallery, IsWhatItWas) {
    const Contents contents = print(world(), {"--threads", "1"});
    EXPECT_EQ(contents.hash, expected_hash(GetParam().name()))
        << "where the change is meant, look at the picture and put this into "
           "tests/scenes/gallery_hashes.txt:\n"
        << GetParam().name() << ' ' << contents.hash;
    for (const auto& [material, voxels] : contents.voxels)
        EXPECT_GT(voxels, 0) << material;
}

/// Instruction sets that this machine has; those of `--target both` on a push.
std::vector<std::string> isas_here() {
    std::vector<std::string> out;
    for (const openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2, OPENFAB_ISA_AVX512}) {
        if (isa == OPENFAB_ISA_AVX512 && !long_run()) continue;
        if (abi::best_isa(isa) == isa) out.emplace_back(abi::isa_name(isa));
    }
    return out;
}

/// The postcard, whose program has both instruction sets, on each push; all exhibits in long runs,
/// with AVX-512.
class GalleryInEveryWay : public Gallery {
  public:
    static std::vector<Exhibit> exhibits() {
        if (!long_run()) return {kExhibits[0]};
        return {std::begin(kExhibits), std::end(kExhibits)};
    }
};

TEST_P(GalleryInEveryWay, PrintsTheSame) {
    if (long_run()) {
        binary_ = *scratch_ / fmt::format("{}-all", GetParam().program);
        const Outcome built = run({program("openflc").string(), "build", fablet().string(), "-o",
                                   binary_.string(), "--target", "all"},
                                  environment());
        ASSERT_EQ(built.exit_code, 0) << built.err;
    }
    for (const std::string& isa : isas_here()) {
        for (const char* threads : {"1", "2", "3", "4", "5"}) {
            if (!long_run() && threads != std::string("2")) continue;
            const Contents contents =
                print(world(), {"--threads", threads, "--no-cull", "--isa", isa});
            EXPECT_EQ(contents.hash, expected_hash(GetParam().name())) << isa << ", " << threads;
        }
    }
}

/// A small exhibit on each push, under one random schedule; in long runs all, under 20, for all
/// instruction sets.
class GalleryUnderSchedules : public Gallery {
  public:
    static std::vector<Exhibit> exhibits() {
        std::vector<Exhibit> out;
        for (const Exhibit& exhibit : kExhibits) {
            if (long_run() || exhibit.world == std::string("blocks")) out.push_back(exhibit);
        }
        return out;
    }

  protected:
    /// Builds the fablet with the schedules of a folder.
    Outcome build(const std::filesystem::path& schedules) {
        binary_ = *scratch_ / "scheduled";
        return run({program("openflc").string(), "build", fablet().string(), "-o", binary_.string(),
                    "--target", long_run() ? "all" : "sse41", "--schedule", schedules.string()},
                   environment());
    }
    void expect_the_same(const std::filesystem::path& schedules) {
        const Outcome built = build(schedules);
        ASSERT_EQ(built.exit_code, 0) << built.err;
        for (const std::string& isa :
             long_run() ? isas_here() : std::vector<std::string>{"sse41"}) {
            const std::string threads = std::to_string(1 + printed_++ % 5);
            EXPECT_EQ(print(world(), {"--isa", isa, "--threads", threads}).hash,
                      expected_hash(GetParam().name()))
                << isa << ", " << threads;
        }
    }

    int printed_ = 0;
};

TEST_P(GalleryUnderSchedules, PrintsTheSame) {
    for (const char* name : {"naive", "overlaps", "strips", "wide"}) {
        SCOPED_TRACE(name);
        expect_the_same(source_dir() / "tests" / "scenes" / "schedules" / name);
    }
    const int count = long_run() ? 20 : 1;
    std::mt19937 random(1);
    for (int k = 0; k < count; ++k) {
        const std::filesystem::path folder = *scratch_ / fmt::format("random{}", k);
        write_random_schedules(fablet(), folder, &random);
        std::string text = "random schedules:\n";
        for (const auto& file : std::filesystem::directory_iterator(folder))
            text +=
                fmt::format("# {}\n{}", file.path().filename().string(), read_file(file.path()));
        SCOPED_TRACE(text);
        expect_the_same(folder);
        if (HasFailure()) return;
    }
}

// `total` is 4096 floats in each of 1024 columns: 16.8 MB for each thread.
TEST_P(GalleryUnderSchedules, ThePlanOfMemoryKnowsWhatIsStored) {
    const std::string usual = "pipeline slab\nvalues_*.compute_root()\n";
    std::map<std::string, int64_t> least;
    for (const std::string more : {"", "total.compute_root().align_storage(z, 4096)\n"}) {
        scratch_->write("mine.sched", usual + more);
        const Outcome built = build(*scratch_ / "mine.sched");
        ASSERT_EQ(built.exit_code, 0) << built.err;
        for (const char* threads : {"1", "3"}) {
            least[threads + more] =
                least_memory_mb(run({binary_.string(), world().string(), "--printer", "generic",
                                     "--voxel", GetParam().voxel, "--memory", "20MB", "--threads",
                                     threads, "-o", (*scratch_ / "no.ofr").string()},
                                    environment()));
            if (more.empty()) continue;
            // The print names a megabyte that suffices for the next run, too (memory_planner.cpp).
            EXPECT_NEAR(static_cast<double>(least[threads + more] - least[threads]),
                        17.0 * std::stoi(threads), 3);
        }
    }
}

class GalleryOfAnyMesh : public Gallery {
  public:
    static std::vector<Exhibit> exhibits() {
        std::vector<Exhibit> out;
        for (const Exhibit& exhibit : kExhibits) {
            if (!exhibit.own_geometry) out.push_back(exhibit);
        }
        return out;
    }
};

TEST_P(GalleryOfAnyMesh, WorksOnForeignMeshes) {
    scratch_->write("ring.obj", ring_obj());
    // The paper's postcard requires an int `face`, which our primitives have.
    const bool needs_faces = std::string(GetParam().folder) == "magic_postcard";
    const std::filesystem::path goat = source_dir() / "tests" / "data" / "meshes" / "goathead.obj";
    const auto file = [](const std::filesystem::path& path) {
        return fmt::format(R"({{"file": "{}", "unit": "mm"}})", path.string());
    };
    const std::vector<std::pair<const char*, std::string>> meshes{
        {"sphere", R"({"sphere": 24})"},
        {"ring", needs_faces ? R"({"box": [24, 20, 3]})" : file(*scratch_ / "ring.obj")},
        {"goat", needs_faces ? R"({"cylinder": [14, 18]})" : file(goat)}};
    const std::vector<std::string> allowed{"--allow", source_dir().string()};
    for (const auto& [name, mesh] : meshes) {
#ifdef OPENFAB_SANITIZED
        if (name != meshes.back().first) continue;
#endif
        const Contents contents = print(world_with(mesh), allowed);
        const auto used = std::count_if(contents.voxels.begin(), contents.voxels.end(),
                                        [](const auto& entry) { return entry.second > 0; });
        EXPECT_GE(used,
                  std::min<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(contents.voxels.size())))
            << name;
        double solid = 0;
        for (const auto& [material, voxels] : contents.voxels)
            solid += voxels;
        EXPECT_GT(solid, 1000) << name;
    }
}

INSTANTIATE_TEST_SUITE_P(Exhibits, Gallery, ::testing::ValuesIn(kExhibits),
                         [](const auto& info) { return info.param.name(); });

INSTANTIATE_TEST_SUITE_P(Exhibits, GalleryOfAnyMesh,
                         ::testing::ValuesIn(GalleryOfAnyMesh::exhibits()),
                         [](const auto& info) { return info.param.name(); });

INSTANTIATE_TEST_SUITE_P(Exhibits, GalleryInEveryWay,
                         ::testing::ValuesIn(GalleryInEveryWay::exhibits()),
                         [](const auto& info) { return info.param.name(); });

INSTANTIATE_TEST_SUITE_P(Exhibits, GalleryUnderSchedules,
                         ::testing::ValuesIn(GalleryUnderSchedules::exhibits()),
                         [](const auto& info) { return info.param.name(); });

}  // namespace
}  // namespace openfab::testing
