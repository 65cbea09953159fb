// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Schedules: how a kernel runs, never what it computes. schedules/README.md is the language's
// reference. A file is read in two steps: parse makes a tree, with the files that it includes in it;
// bind decides what depends on the target and on parameters, and returns a list of lines.
// compiler/lower/schedule/apply_schedule.h checks those against a kernel and applies them.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace openfab::schedule {

/// The largest number in a schedule: of a factor, an extent, a parameter.
constexpr int64_t kMostNumber = 65536;

/// A mistake in a schedule file; columns count bytes from 1.
struct Fault {
    std::string message;
    std::string help;   ///< may be empty
    uint32_t file = 0;  ///< of the Source
    int32_t line = 0;
    int32_t column = 0;
    int32_t length = 1;
    size_t offset = 0;  ///< of the column in the file's text
};

struct Word {
    std::string text;  ///< of a bound argument that is a number: the number
    uint32_t file = 0;
    int32_t line = 0;
    int32_t column = 0;
    int32_t length = 1;
    size_t offset = 0;
};

/// Returns a fault at a word.
Fault fault_at(const Word& word, std::string message, std::string help = {});

/// `name(arg, …)`; the condition of `specialize` is one word an operand and operator.
struct Directive {
    Word name;
    std::vector<Word> args;
};

/// A chain of directives for a Func, or for all those that a pattern `prefix*` matches.
struct Line {
    Word func;
    std::vector<Directive> directives;
};

/// `param name = value in [least, most]`, or `in {one, of, these}`.
struct Param {
    Word name;
    int64_t value = 0;
    bool is_range = false;         ///< `choices` are the least and the most
    std::vector<int64_t> choices;  ///< ascending
    std::string path;              ///< of its Source

    bool allows(int64_t number) const;
    /// Returns the set as it is written: "[4, 64]".
    std::string set() const;
};

/// What follows `when`: a target, or a comparison of numbers; `not`, `and`, `or` of such.
struct Condition {
    enum class Kind { kTarget, kCompare, kNot, kAnd, kOr };
    Kind kind = Kind::kTarget;
    std::vector<Word> words;            ///< target; or left, operator, right
    std::vector<Condition> conditions;  ///< of kNot, kAnd, kOr
};

struct Item;

/// `when … { … } else { … }`: the first branch whose condition holds; the last may have none.
struct When {
    struct Branch {
        std::optional<Condition> condition;
        std::vector<Item> items;
    };
    std::vector<Branch> branches;
};

struct Item {
    std::variant<Line, Param, When> what;
};

/// A file's text.
struct Source {
    std::string path;  ///< as the user named it, or "schedules/slab.sched"
    std::string text;
    uint32_t file = 0;  ///< number that words and faults carry: whose caret it is
};

/// Opens the file that `from` includes as `name`, or returns why it cannot be read.
using OpenFile =
    std::function<std::variant<Source, std::string>(const std::string& name, const Source& from)>;

/// Opens built-in schedules only, for text that is not from a file.
std::variant<Source, std::string> open_built_in(const std::string& name, const Source& from);

struct File {
    std::string path;
    uint32_t file = 0;                     ///< of the Source
    std::optional<Word> pipeline;          ///< of the `pipeline` line
    std::vector<Word> included_pipelines;  ///< of those of the files that it includes
    std::vector<Item> items;
};

/// Parses a file and those that it includes: form, directives, number of arguments, sets of
/// parameters.
std::variant<File, Fault> parse(const Source& source, const OpenFile& open = open_built_in);

/// What a schedule is bound to.
struct Binding {
    std::string target = "sse41";           ///< isa_name
    std::map<std::string, int64_t> params;  ///< values in place of the file's own
};

/// A schedule for one target: lines without choices, every argument a name or a number.
struct Schedule {
    std::string path;
    uint32_t file = 0;  ///< of the Source
    std::string target;
    std::vector<Param> params;  ///< as bound, in order
    std::vector<Line> lines;
};

/// Chooses branches and puts numbers in the place of parameters. Params of the binding that the
/// file lacks are ignored: see has_param.
std::variant<Schedule, Fault> bind(const File& file, const Binding& binding = {});

/// Returns whether the file declares the parameter, in whatever branch.
bool has_param(const File& file, const std::string& name);

/// Parses and binds.
std::variant<Schedule, Fault> read(const Source& source, const Binding& binding = {});

/// Returns the first word of a schedule, for what is wrong with it as a whole.
Word start_of(const Schedule& schedule);

/// Returns a bound schedule's lines in canonical form: equal texts are equal schedules, and the
/// text is a file that binds to it for any target.
std::string text_of(const Schedule& schedule);

/// Returns the names of the targets that `when` knows, smallest vectors first. A target has all
/// before it.
const std::vector<std::string>& targets();
/// Returns how many floats a vector of the target holds: the number `vector_lanes`.
int64_t vector_lanes(std::string_view target);

/// Returns the built-in file of a kernel ("slab") for a target ("avx2"):
/// `<kernel>.<target>.sched` if there is one, else `<kernel>.sched`; null if there is neither.
const File* default_file(std::string_view kernel, std::string_view target);
/// The parameter of built-in schedules that is 1 in kernels of arithmetic alone: nothing is gained
/// from batches there.
constexpr std::string_view kBatchParam = "groups";

/// Returns that of a kernel that has one, bound to the target and to its own parameters. `batches`:
/// whether it looks pictures up, asks for nearest points or has a rule.
const Schedule& default_schedule(std::string_view kernel, std::string_view target,
                                 bool batches = true);

}  // namespace openfab::schedule
