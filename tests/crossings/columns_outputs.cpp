// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Columns of outputs: the same print, written or continued in another way. The twin is that print itself.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <regex>

#include "backends/formats/formats.h"
#include "tests/crossings/columns.h"

namespace openfab::testing {

namespace {

namespace fs = std::filesystem;

/// All bytes of a file, of the files of a folder, or of files that are named after it, one a material.
std::string all_of(const fs::path& path) {
    std::map<std::string, fs::path> files;
    const auto add = [&](const fs::path& file, size_t from) {
        if (fs::is_regular_file(file)) files[file.string().substr(from)] = file;
    };
    const std::string stem = path.parent_path() / path.stem();
    for (const auto& entry : fs::directory_iterator(path.parent_path())) {
        if (entry.path().string().starts_with(stem)) add(entry.path(), stem.size());
    }
    if (fs::is_directory(path)) {
        for (const auto& entry : fs::recursive_directory_iterator(path))
            add(entry.path(), path.string().size());
    }
    // A print keeps a record beside its output; an export has none.
    std::string out;
    for (const auto& [name, file] : files) {
        if (!name.ends_with(".job.json")) out += name + read_file(file);
    }
    return out;
}

/// Prints to one file and again in another way, which must give the same bytes.
Made twice(const Bench& bench, const std::string& whole, const std::string& other,
           const std::function<Outcome()>& again) {
    Made made;
    made.outcome = bench.print(whole);
    if (made.outcome.exit_code != 0) return made;
    const Outcome second = again();
    if (second.exit_code != 0) {
        made.wrong = "the second time: " + second.err;
    } else if (read_file(bench.path(whole)) != read_file(bench.path(other))) {
        made.wrong = "not the bytes of one print";
    }
    return made;
}

int slices_of(const Bench& bench) {
    bench.print("size.npy");
    return read_voxels(bench.path("size.npy")).size[2];
}

Made threads(const Bench& bench) {
    return twice(bench, "a.ofr", "b.ofr", [&] {
        return bench.print("b.ofr", {"--threads", "1", "--no-cull"});
    });
}

Made shares(const Bench& bench) {
    return twice(bench, "a.ofr", "b.ofr", [&] {
        const int slices = slices_of(bench), half = slices / 2;
        Outcome made = bench.print("low.ofr", {"--slices", fmt::format("0:{}", half)});
        if (made.exit_code != 0) return made;
        made = bench.print("high.ofr", {"--slices", fmt::format("{}:{}", half, slices)});
        if (made.exit_code != 0) return made;
        return bench.openfab({"merge", "low.ofr", "high.ofr", "-o", "b.ofr"}, false);
    });
}

Made resume(const Bench& bench) {
    return twice(bench, "a.ofr", "b.ofr", [&] {
        const std::string whole = read_file(bench.path("a.ofr"));
        bench.write("b.ofr", whole.substr(0, whole.size() * 6 / 10));
        return bench.print("b.ofr", {"--resume"});
    });
}

/// With as much as the refusal of too little asks for, which is the process's own size, too: that varies a little.
Made memory(const Bench& bench) {
    return twice(bench, "a.ofr", "b.ofr", [&] {
        Outcome tried;
        std::string enough = "16";  // meshes are read with as much
        for (int times = 0; times < 4; ++times) {
            tried = bench.print("b.ofr", {"--memory", enough + "MB", "--threads", "1"});
            std::smatch least;
            if (!std::regex_search(tried.err, least, std::regex("at least ([0-9]+) MB"))) break;
            enough = least[1];
        }
        return tried;
    });
}

/// Each format of a direct print is that of an export.
Made format(const Bench& bench) {
    const std::string name = bench.change().options.back();
    const backends::Format* format = backends::find_format(name);
    const std::string end =
        format->kind == backends::FormatKind::kFolder ? "" : std::string(format->extension);
    Made made;
    made.outcome = bench.print("direct" + end);
    if (made.outcome.exit_code != 0) return made;
    if (format->of_fractions) {
        // Mixtures are in no print: as many slices as of the twin show something.
        std::vector<uintmax_t> sizes;
        for (const auto& entry : fs::directory_iterator(bench.path("direct" + end))) {
            if (entry.path().extension() != ".json") sizes.push_back(entry.file_size());
        }
        const uintmax_t least = *std::min_element(sizes.begin(), sizes.end());
        made.numbers["slices"] = static_cast<double>(
            std::count_if(sizes.begin(), sizes.end(), [&](uintmax_t s) { return s > least; }));
        return made;
    }
    std::vector<std::string> words{"print", bench.world(), "-o",
                                   "a.ofr", "--pitch",     "0.25,0.25,0.25"};
    // Meshes have the largest material of each voxel, as documents say.
    if (format->kind == backends::FormatKind::kMesh)
        words.insert(words.end(), {"--dither", "majority"});
    Outcome second = bench.openfab(words);
    if (second.exit_code == 0)
        second = bench.openfab({"export", "a.ofr", "-o", "again" + end, "--format", name}, false);
    if (second.exit_code != 0) {
        made.wrong = "the export: " + second.err;
    } else if (const std::string direct = all_of(bench.path("direct" + end)); direct.empty()) {
        made.wrong = "the print wrote nothing";
    } else if (direct != all_of(bench.path("again" + end))) {
        made.wrong = "the export has other bytes";
    }
    return made;
}

Made preview(const Bench& bench) {
    Made made;
    made.outcome = bench.print("a.ofr", {"--preview", bench.path("a.png") + ",view=section"});
    if (made.outcome.exit_code != 0) return made;
    const Outcome second = bench.openfab(
        {"export", "a.ofr", "--preview", bench.path("b.png") + ",view=section"}, false);
    if (second.exit_code != 0) made.wrong = second.err;
    if (read_file(bench.path("a.png")) != read_file(bench.path("b.png")))
        made.wrong = "the picture of the print is another than of its slices";
    return made;
}

}  // namespace

std::vector<Column> output_columns() {
    std::vector<Column> all{
        {"threads", "one thread, without culling", {}, threads, {"--threads"}},
        {"shares", "in two shares, merged", {}, shares, {"merge", "--slices", "ofr"}},
        {"resume", "resumed", {}, resume, {"--resume"}},
        {"memory", "`--memory` at its least", {}, memory, {"--memory"}},
        {"preview", "a picture of it", {}, preview, {"--preview", "export"}},
    };
    for (const backends::Format* format : backends::formats()) {
        if (format->needs_mixtures) continue;  // has no codes to compare, see elsewhere.cpp
        const std::string name(format->name);
        Column column{"as " + name,
                      "as `" + name + "`",
                      {},
                      openfab::testing::format,
                      {name, "--mesh-pitch"}};
        if (format->kind == backends::FormatKind::kMesh)
            column.change.options = {"--mesh-pitch", "0.25mm"};
        column.change.options.insert(column.change.options.end(), {"--format", name});
        all.push_back(std::move(column));
    }
    return all;
}

}  // namespace openfab::testing
