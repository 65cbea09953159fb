// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/schedules.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include "abi/kernel_call.h"
#include "base/input_file.h"
#include "base/near_miss.h"
#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"

namespace openfab::driver {

namespace {

namespace fs = std::filesystem;

bool holds(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Returns the parts of a file's name: `slab.avx2.sched`.
std::vector<std::string> name_parts(const fs::path& path) {
    std::vector<std::string> out(1);
    for (const char c : path.filename().string()) {
        if (c == '.') {
            out.emplace_back();
        } else {
            out.back() += c;
        }
    }
    return out;
}

/// Opens a file that another includes: beside it, else a built-in one. A file that is named after its
/// pipeline may include the built-in one of that name.
std::variant<schedule::Source, std::string> open_included(source::SourceManager* sources,
                                                          const std::string& name,
                                                          const schedule::Source& from) {
    const fs::path folder = sources->folder(from.file);
    std::error_code error;
    auto built_in = schedule::open_built_in(name, from);
    const bool is_built_in = std::holds_alternative<schedule::Source>(built_in);
    const std::string beside = fs::weakly_canonical(folder / name, error).string();
    if (!folder.empty() && fs::is_regular_file(folder / name, error) &&
        !(is_built_in && beside == from.path)) {
        // Who wrote the file is not always who compiles with it.
        std::string fault;
        const std::optional<uint32_t> file =
            sources->load(folder / name, &fault, {reading_root(folder)});
        if (!file) return fault;
        return schedule::Source{beside, std::string(sources->text(*file)), *file};
    }
    if (!is_built_in)
        return "there is no such file beside this one, nor a built-in schedule of that name";
    auto& source = std::get<schedule::Source>(built_in);
    source.file = sources->add(source.path, source.text);
    return source;
}

}  // namespace

int Schedules::report(const schedule::Fault& fault) const {
    lower::Fault all;
    all.schedule = fault;
    return report_fault(all, *sources_, common_);
}

int Schedules::parse(const schedule::Source& source, schedule::File* out) {
    auto parsed = schedule::parse(source, [&](const std::string& name, const auto& from) {
        return open_included(sources_, name, from);
    });
    if (const auto* bad = std::get_if<schedule::Fault>(&parsed)) return report(*bad);
    *out = std::get<schedule::File>(std::move(parsed));
    return kExitDone;
}

int Schedules::load_path(const std::string& path) {
    std::error_code error;
    if (!fs::is_directory(path, error)) return load_file(path);
    // A folder is a machine's: one file a pipeline, or one for each target. What it has beside them
    // may be what these include.
    std::vector<fs::path> files;
    for (auto each = fs::directory_iterator(path, error);
         !error && each != fs::directory_iterator(); each.increment(error)) {
        std::error_code none;
        if (each->path().extension() == ".sched" && each->is_regular_file(none) &&
            holds(lower::pipeline_names(), name_parts(each->path())[0]))
            files.push_back(each->path());
    }
    if (error) return fail(fmt::format("{}: {}", path, error.message()), kExitOutside);
    if (files.empty()) {
        return fail(
            fmt::format("{}: the folder has no schedule; their names begin with a pipeline's, "
                        "as in slab.sched or slab.avx2.sched",
                        path),
            kExitUserInput);
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
        if (const int code = load_file(file.string()); code != kExitDone) return code;
    }
    return kExitDone;
}

int Schedules::load_file(const std::string& path) {
    std::string fault;
    const std::optional<uint32_t> number = sources_->load(path, &fault);
    if (!number) return fail(fault, unread_exit_code(path));
    std::error_code error;
    Loaded loaded;
    loaded.path = path;
    const int code = parse(
        {fs::weakly_canonical(path, error).string(), std::string(sources_->text(*number)), *number},
        &loaded.file);
    if (code != kExitDone) return code;
    loaded.file.path = fs::path(path).filename().string();
    const std::vector<std::string>& known = lower::pipeline_names();
    const std::vector<std::string> parts = name_parts(path);
    if (parts.size() > 2 && holds(schedule::targets(), parts[1])) loaded.target = parts[1];
    loaded.pipeline = parts[0];
    if (loaded.file.pipeline) {
        const schedule::Word& word = *loaded.file.pipeline;
        loaded.pipeline = word.text;
        if (!holds(known, word.text)) {
            return report(schedule::fault_at(word,
                                             fmt::format("no pipeline is called `{}`", word.text),
                                             suggest(word.text, known)));
        }
    } else if (!holds(known, loaded.pipeline)) {
        return fail(fmt::format("{}: no pipeline is called `{}`; name the file after the pipeline "
                                "it is for, as in slab.sched, or begin it with a line such as "
                                "`pipeline slab`",
                                path, loaded.pipeline),
                    kExitUserInput);
    }
    for (const schedule::Word& word : loaded.file.included_pipelines) {
        if (word.text == loaded.pipeline) continue;
        return report(schedule::fault_at(
            word,
            fmt::format("this file is for the pipeline `{}`, and is included in one for `{}`",
                        word.text, loaded.pipeline),
            "without this line it is for every pipeline that includes it"));
    }
    for (const Loaded& other : files_) {
        if (other.pipeline != loaded.pipeline || other.target != loaded.target) continue;
        return fail(
            fmt::format("{} and {} are both for the pipeline `{}`{}", other.path, path,
                        loaded.pipeline, loaded.target.empty() ? "" : " and the same target"),
            kExitUserInput);
    }
    files_.push_back(std::move(loaded));
    return kExitDone;
}

int Schedules::parse_params(const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        const size_t sign = word.find('=');
        int64_t value = 0;
        const char* end = word.data() + word.size();
        const char* begin = sign == std::string::npos ? end : word.data() + sign + 1;
        const auto [stop, error] = std::from_chars(begin, end, value);
        if (sign == std::string::npos || sign == 0 || error != std::errc() || stop != end) {
            return fail(fmt::format("`--param {}`: write a name and a whole number, as in `--param "
                                    "batch=32`",
                                    word),
                        kExitUsage);
        }
        params_[word.substr(0, sign)] = value;
    }
    return kExitDone;
}

const Schedules::Loaded* Schedules::choose(const std::string& pipeline,
                                           const std::string& target) const {
    const Loaded* out = nullptr;
    for (const Loaded& each : files_) {
        if (each.pipeline != pipeline || (!each.target.empty() && each.target != target)) continue;
        if (out == nullptr || out->target.empty()) out = &each;
    }
    return out;
}

const schedule::File& Schedules::file(const std::string& pipeline, openfab_isa isa) const {
    const Loaded* chosen = choose(pipeline, abi::isa_name(isa));
    return chosen != nullptr ? chosen->file : *schedule::default_file(pipeline, abi::isa_name(isa));
}

int Schedules::bind(const std::string& pipeline, openfab_isa isa) {
    const std::string target = abi::isa_name(isa);
    const auto knows_any = [&](const schedule::File& file) {
        bool any = false;
        for (auto& [name, known] : param_is_known_) {
            const bool here = schedule::has_param(file, name);
            known = known || here;
            any = any || here;
        }
        return any;
    };
    schedule::File built_in;
    const Loaded* chosen = choose(pipeline, target);
    if (chosen != nullptr) {
        knows_any(chosen->file);
    } else {
        const schedule::File* own = schedule::default_file(pipeline, target);
        if (own == nullptr || !knows_any(*own)) return kExitDone;
        // Once more, so that a message finds its text.
        auto opened = open_included(sources_, fs::path(own->path).filename().string(), {});
        if (const int code = parse(std::get<schedule::Source>(opened), &built_in);
            code != kExitDone) {
            return code;
        }
    }
    auto bound = schedule::bind(chosen != nullptr ? chosen->file : built_in,
                                {.target = target, .params = params_});
    if (const auto* bad = std::get_if<schedule::Fault>(&bound)) return report(*bad);
    bound_[{pipeline, isa}] = std::get<schedule::Schedule>(std::move(bound));
    return kExitDone;
}

int Schedules::load(const ScheduleOptions& options, const std::vector<openfab_isa>& isas) {
    if (const int code = parse_params(options.params); code != kExitDone) return code;
    for (const std::string& path : options.paths) {
        if (const int code = load_path(path); code != kExitDone) return code;
    }
    for (const auto& [name, value] : params_)
        param_is_known_[name] = false;
    for (const std::string& pipeline : lower::pipeline_names()) {
        for (const openfab_isa isa : isas) {
            if (const int code = bind(pipeline, isa); code != kExitDone) return code;
        }
    }
    for (const auto& [name, known] : param_is_known_) {
        if (known) continue;
        return fail(
            fmt::format("`--param {}`: no schedule in use has a parameter of that name", name),
            kExitUsage);
    }
    return kExitDone;
}

}  // namespace openfab::driver
