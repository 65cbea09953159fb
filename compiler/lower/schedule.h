// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Schedules: how a kernel runs, never what it computes. schedules/README.md is the language's
// reference. A file is read in two steps: parse_schedule makes a tree, with the files that it
// includes in it; bind_schedule decides what depends on the target and on parameters, and returns
// a list of lines. apply_schedule.h checks those against a kernel and applies them.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace openfab::lower {

/// The largest number in a schedule: of a factor, an extent, a parameter.
constexpr int64_t kMostScheduleNumber = 65536;

/// A mistake in a schedule file; columns count bytes from 1.
struct ScheduleFault {
    std::string id = "schedule-illegal";
    std::string message;
    std::string help;   ///< may be empty
    uint32_t file = 0;  ///< of the ScheduleSource
    int32_t line = 0;
    int32_t column = 0;
    int32_t length = 1;
    size_t offset = 0;  ///< of the column in the file's text
};

struct ScheduleWord {
    std::string text;  ///< of a bound argument that is a number: the number
    uint32_t file = 0;
    int32_t line = 0;
    int32_t column = 0;
    int32_t length = 1;
    size_t offset = 0;
};

/// Returns a fault at a word.
ScheduleFault fault_at(const ScheduleWord& word, std::string message, std::string help = {});

/// `name(arg, …)`; the condition of `specialize` is one word an operand and operator.
struct Directive {
    ScheduleWord name;
    std::vector<ScheduleWord> args;
};

/// A chain of directives for a Func, or for all those that a pattern `prefix*` matches.
struct ScheduleLine {
    ScheduleWord func;
    std::vector<Directive> directives;
};

/// `param name = value in [least, most]`, or `in {one, of, these}`.
struct ScheduleParam {
    ScheduleWord name;
    int64_t value = 0;
    bool is_range = false;         ///< `choices` are the least and the most
    std::vector<int64_t> choices;  ///< ascending

    bool allows(int64_t number) const;
    /// Returns the set as it is written: "[4, 64]".
    std::string set() const;
};

/// What follows `when`: a target, or a comparison of numbers; `not`, `and`, `or` of such.
struct ScheduleCondition {
    enum class Kind { kTarget, kCompare, kNot, kAnd, kOr };
    Kind kind = Kind::kTarget;
    std::vector<ScheduleWord> words;            ///< target; or left, operator, right
    std::vector<ScheduleCondition> conditions;  ///< of kNot, kAnd, kOr
};

struct ScheduleItem;

/// `when … { … } else { … }`: the first branch whose condition holds; the last may have none.
struct ScheduleWhen {
    struct Branch {
        std::optional<ScheduleCondition> condition;
        std::vector<ScheduleItem> items;
    };
    std::vector<Branch> branches;
};

struct ScheduleItem {
    std::variant<ScheduleLine, ScheduleParam, ScheduleWhen> what;
};

/// A file's text.
struct ScheduleSource {
    std::string path;  ///< as the user named it, or "schedules/volume.sched"
    std::string text;
    uint32_t file = 0;  ///< number that words and faults carry: whose caret it is
};

/// Opens the file that `from` includes as `name`, or returns why it cannot be read.
using OpenSchedule = std::function<std::variant<ScheduleSource, std::string>(
    const std::string& name, const ScheduleSource& from)>;

/// Opens built-in schedules only, for text that is not from a file.
std::variant<ScheduleSource, std::string> open_built_in(const std::string& name,
                                                        const ScheduleSource& from);

struct ScheduleFile {
    std::string path;
    std::optional<ScheduleWord> pipeline;  ///< of the `pipeline` line
    std::vector<ScheduleItem> items;
};

/// Parses a file and those that it includes: form, directives, number of arguments, sets of
/// parameters.
std::variant<ScheduleFile, ScheduleFault> parse_schedule(const ScheduleSource& source,
                                                         const OpenSchedule& open = open_built_in);

/// What a schedule is bound to.
struct ScheduleBinding {
    std::string target = "sse41";           ///< isa_name
    std::map<std::string, int64_t> params;  ///< values in place of the file's own
};

/// A schedule for one target: lines without choices, every argument a name or a number.
struct Schedule {
    std::string path;
    std::string target;
    std::vector<ScheduleParam> params;  ///< as bound, in order
    std::vector<ScheduleLine> lines;
};

/// Chooses branches and puts numbers in the place of parameters. Params of the binding that the
/// file lacks are ignored: see has_param.
std::variant<Schedule, ScheduleFault> bind_schedule(const ScheduleFile& file,
                                                    const ScheduleBinding& binding = {});

/// Returns whether the file declares the parameter, in whatever branch.
bool has_param(const ScheduleFile& file, const std::string& name);

/// Parses and binds.
std::variant<Schedule, ScheduleFault> read_schedule(const ScheduleSource& source,
                                                    const ScheduleBinding& binding = {});

/// Returns a bound schedule's lines in canonical form: equal texts are equal schedules, and the
/// text is a file that binds to it for any target.
std::string schedule_text(const Schedule& schedule);

/// Returns the names of the targets that `when` knows, smallest vectors first. A target has all
/// before it.
const std::vector<std::string>& schedule_targets();
/// Returns how many floats a vector of the target holds: the number `vector_lanes`.
int64_t vector_lanes(std::string_view target);

/// Returns the built-in file of a kernel ("volume") for a target ("avx2"):
/// `<kernel>.<target>.sched` if there is one, else `<kernel>.sched`; null if there is neither.
const ScheduleFile* default_schedule_file(std::string_view kernel, std::string_view target);
/// Returns that of a kernel that has one, bound to the target and to its own parameters.
const Schedule& default_schedule(std::string_view kernel, std::string_view target);

}  // namespace openfab::lower
