// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/schedule/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>

#include "base/near_miss.h"
#include "compiler/schedule/default_schedules.h"
#include "compiler/schedule/rules.h"

namespace openfab::schedule {

namespace {

// The slab kernel's number of columns that are written out where it is arithmetic alone. In code for
// SSE4.1 that would take a fifth longer to compile for 1 to 3 % (docs/measurements/schedules.md).
constexpr const char* kCopiesParam = "copies";
constexpr int64_t kCopies = 4;

std::vector<std::string> built_in_names() {
    std::vector<std::string> out;
    for (const EmbeddedText& file : kSchedules)
        out.emplace_back(file.name);
    return out;
}

Source built_in_source(const EmbeddedText& file) {
    return {fmt::format("schedules/{}", file.name), std::string(file.text), 0};
}

[[noreturn]] void stop(std::string_view path, const Fault& fault) {
    fmt::print(stderr, "{}:{}:{}: internal error: {}\n", path, fault.line, fault.column,
               fault.message);
    std::abort();
}

const std::map<std::string, File, std::less<>>& built_in_files() {
    static const std::map<std::string, File, std::less<>> parsed = [] {
        std::map<std::string, File, std::less<>> out;
        for (const EmbeddedText& file : kSchedules) {
            auto made = parse(built_in_source(file));
            if (const auto* fault = std::get_if<Fault>(&made)) stop(file.name, *fault);
            out[std::string(file.name)] = std::get<File>(std::move(made));
        }
        return out;
    }();
    return parsed;
}

/// `a % 4 == 0`, or `x, y`.
std::string args_text(const Directive& directive) {
    std::vector<std::string> words;
    for (const Word& arg : directive.args)
        words.push_back(arg.text);
    const DirectiveRule* rule = find_rule(directive.name.text);
    const bool condition =
        rule != nullptr && !rule->args.empty() && rule->args[0] == ArgKind::kCondition;
    return fmt::format("{}", fmt::join(words, condition ? " " : ", "));
}

}  // namespace

bool Param::allows(int64_t number) const {
    if (is_range) return number >= choices.front() && number <= choices.back();
    return std::find(choices.begin(), choices.end(), number) != choices.end();
}

std::string Param::set() const {
    return fmt::format("{}{}{}", is_range ? '[' : '{', fmt::join(choices, ", "),
                       is_range ? ']' : '}');
}

std::variant<Source, std::string> open_built_in(const std::string& name, const Source& from) {
    const auto* file = std::find_if(std::begin(kSchedules), std::end(kSchedules),
                                    [&](const EmbeddedText& f) { return f.name == name; });
    if (file != std::end(kSchedules)) {
        Source source = built_in_source(*file);
        source.file = from.file;
        return source;
    }
    return fmt::format("no built-in schedule is called so; {}",
                       near_or_all(name, built_in_names(), "there are"));
}

std::variant<Schedule, Fault> read(const Source& source, const Binding& binding) {
    auto parsed = parse(source);
    if (auto* fault = std::get_if<Fault>(&parsed)) return std::move(*fault);
    return bind(std::get<File>(parsed), binding);
}

Word start_of(const Schedule& schedule) {
    if (!schedule.lines.empty()) return schedule.lines.front().func;
    Word word;
    word.file = schedule.file;
    word.line = word.column = 1;
    return word;
}

std::string text_of(const Schedule& schedule) {
    std::string out;
    for (const Line& line : schedule.lines) {
        out += line.func.text;
        for (const Directive& directive : line.directives)
            out += fmt::format(".{}({})", directive.name.text, args_text(directive));
        out += '\n';
    }
    return out;
}

const File* default_file(std::string_view kernel, std::string_view target) {
    const auto& files = built_in_files();
    for (const std::string& name :
         {fmt::format("{}.{}.sched", kernel, target), fmt::format("{}.sched", kernel)}) {
        if (const auto found = files.find(name); found != files.end()) return &found->second;
    }
    return nullptr;
}

const Schedule& default_schedule(std::string_view kernel, std::string_view target, bool batches) {
    const auto key = [](std::string_view stem, std::string_view of, bool with_batches) {
        return fmt::format("{} {} {}", stem, of, with_batches);
    };
    // Bound at once for every target: kernels are compiled in several threads.
    static const std::map<std::string, Schedule> bound = [&] {
        std::map<std::string, Schedule> out;
        const auto add = [&](const std::string& stem, const std::string& each, bool with_batches) {
            const File* chosen = default_file(stem, each);
            if (chosen == nullptr) return;
            Binding binding{.target = each, .params = {}};
            if (!with_batches) {
                binding.params[std::string(kBatchParam)] = 1;
                binding.params[kCopiesParam] = vector_lanes(each) >= 8 ? kCopies : 1;
            }
            auto made = bind(*chosen, binding);
            if (const auto* fault = std::get_if<Fault>(&made)) stop(stem, *fault);
            out[key(stem, each, with_batches)] = std::get<Schedule>(std::move(made));
        };
        for (const auto& [name, file] : built_in_files()) {
            for (const std::string& each : targets()) {
                for (const bool with_batches : {false, true})
                    add(name.substr(0, name.find('.')), each, with_batches);
            }
        }
        return out;
    }();
    return bound.at(key(kernel, target, batches));
}

}  // namespace openfab::schedule
