// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// parse: recursive descent over the tokens. An included file's items take the place of
// its line.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "compiler/schedule/rules.h"
#include "compiler/schedule/schedule.h"
#include "compiler/schedule/tokens.h"

namespace openfab::schedule {

namespace {

using Kind = Token::Kind;

constexpr size_t kMostDepth = 8;     // of files in files, and of `when` in `when`
constexpr int kMostFiles = 64;       // that one file includes, over all
constexpr int kMostItems = 4096;     // lines, over all
constexpr size_t kMostChoices = 64;  // of a parameter

/// What the parsers of a file and of those that it includes share.
struct Parsing {
    const OpenFile& open;
    std::vector<std::string> paths;  ///< of files that are being parsed
    int files = 0;
    int items = 0;
};

class Parser {
  public:
    Parser(const Source& source, Parsing* all) : source_(source), all_(all) {}

    std::variant<File, Fault> run() {
        auto tokens = tokens_of(source_);
        if (auto* fault = std::get_if<Fault>(&tokens)) return std::move(*fault);
        tokens_ = std::get<std::vector<Token>>(std::move(tokens));
        file_.path = source_.path;
        file_.file = source_.file;
        if (!block(&file_.items, 0)) return std::move(fault_);
        return std::move(file_);
    }

  private:
    const Token& peek() const { return tokens_[at_]; }
    const Token& take() { return tokens_[peek().kind == Kind::kEnd ? at_ : at_++]; }
    bool at_end_of_line() const {
        return peek().kind == Kind::kNewLine || peek().kind == Kind::kEnd;
    }
    bool accept(std::string_view text) {
        if (!peek().is(text)) return false;
        take();
        return true;
    }
    bool fail(const Word& where, std::string message, std::string help = {}) {
        fault_ = fault_at(where, std::move(message), std::move(help));
        return false;
    }
    bool expect(std::string_view text, const char* where) {
        if (accept(text)) return true;
        return fail(peek().word, fmt::format("expected `{}` {}", text, where));
    }
    bool expect_word(const char* what, Word* out) {
        if (peek().kind != Kind::kWord) return fail(peek().word, fmt::format("expected {}", what));
        *out = take().word;
        return true;
    }
    void skip_lines() {
        while (peek().kind == Kind::kNewLine)
            take();
    }

    /// Parses items up to the end of the file, or up to `}` of a branch.
    bool block(std::vector<Item>* out, size_t depth) {
        for (skip_lines(); peek().kind != Kind::kEnd && !peek().is("}"); skip_lines()) {
            if (++all_->items > kMostItems) {
                return fail(peek().word, fmt::format("a schedule has at most {} lines, those of "
                                                     "the files that it includes among them",
                                                     kMostItems));
            }
            if (!item(out, depth)) return false;
            if (!at_end_of_line() && !peek().is("}"))
                return fail(peek().word, "expected the end of the line");
        }
        if (depth == 0 && peek().is("}")) return fail(peek().word, "no `{` belongs to this `}`");
        return true;
    }

    bool item(std::vector<Item>* out, size_t depth) {
        if (peek().is("include")) return include(out, depth);
        if (peek().is("pipeline")) return pipeline(depth);
        if (peek().is("param")) return param(out);
        if (peek().is("when")) return when(out, depth);
        if (peek().is("else")) return fail(peek().word, "`else` follows the `}` of a `when`");
        return line(out);
    }

    bool pipeline(size_t depth) {
        const Word keyword = take().word;
        Word name;
        if (!expect_word("the name of a pipeline, as in `pipeline slab`", &name)) return false;
        if (depth > 0 || file_.pipeline)
            return fail(keyword, "a file is for one pipeline, whatever the target");
        file_.pipeline = name;
        return true;
    }

    bool include(std::vector<Item>* out, size_t depth) {
        take();
        if (peek().kind != Kind::kString) {
            return fail(peek().word, "expected the name of a file in quotes",
                        "write `include \"common.sched\"`");
        }
        const Word name = take().word;
        if (all_->paths.size() + depth >= kMostDepth)
            return fail(name, fmt::format("files include each other {} deep", kMostDepth));
        if (++all_->files > kMostFiles)
            return fail(name, fmt::format("a schedule includes at most {} files", kMostFiles));
        std::variant<Source, std::string> opened = all_->open(name.text, source_);
        if (const auto* why = std::get_if<std::string>(&opened))
            return fail(name, fmt::format("`{}` cannot be included", name.text), *why);
        const auto& source = std::get<Source>(opened);
        if (std::find(all_->paths.begin(), all_->paths.end(), source.path) != all_->paths.end())
            return fail(name, fmt::format("`{}` includes itself", name.text),
                        "put what both need into a third file");
        all_->paths.push_back(source.path);
        std::variant<File, Fault> parsed = Parser(source, all_).run();
        all_->paths.pop_back();
        if (auto* fault = std::get_if<Fault>(&parsed)) {
            fault_ = std::move(*fault);
            return false;
        }
        auto& file = std::get<File>(parsed);
        if (file.pipeline) file_.included_pipelines.push_back(*file.pipeline);
        for (const Word& word : file.included_pipelines)
            file_.included_pipelines.push_back(word);
        for (Item& item : file.items)
            out->push_back(std::move(item));
        return true;
    }

    bool number(int64_t least, int64_t* out) {
        const Word word = peek().word;
        const char* end = word.text.data() + word.text.size();
        const auto [stop, error] = std::from_chars(word.text.data(), end, *out);
        if (peek().kind != Kind::kWord || error != std::errc() || stop != end || *out < least ||
            *out > kMostNumber) {
            return fail(word,
                        fmt::format("expected a whole number from {} to {}", least, kMostNumber));
        }
        take();
        return true;
    }

    bool param(std::vector<Item>* out) {
        take();
        Param param;
        param.path = source_.path;
        if (!expect_word("a name for the parameter", &param.name)) return false;
        if (!is_name(param.name.text) || param.name.text == kVectorLanes)
            return fail(param.name, fmt::format("`{}` cannot name a parameter", param.name.text));
        if (!expect("=", "and a value after the parameter's name")) return false;
        const Word default_word = peek().word;
        if (!number(1, &param.value)) return false;
        if (!expect("in", "and the values that the parameter may have, as in `in [4, 64]`"))
            return false;
        const Word set = peek().word;
        param.is_range = accept("[");
        if (!param.is_range && !expect("{", "or `[` after `in`")) return false;
        do {
            int64_t choice = 0;
            if (!number(1, &choice)) return false;
            param.choices.push_back(choice);
        } while (accept(","));
        if (!expect(param.is_range ? "]" : "}", "after the values")) return false;
        if (param.is_range && (param.choices.size() != 2 || param.choices[0] > param.choices[1]))
            return fail(set, "a range is `[least, most]`");
        if (param.choices.size() > kMostChoices)
            return fail(set, fmt::format("a parameter has at most {} values", kMostChoices));
        std::sort(param.choices.begin(), param.choices.end());
        if (!param.allows(param.value)) {
            return fail(default_word, fmt::format("{} is not in {}", param.value, param.set()));
        }
        out->push_back({std::move(param)});
        return true;
    }

    static bool is_name(std::string_view text) {
        return text.find('*') == std::string_view::npos && (text[0] < '0' || text[0] > '9');
    }

    bool when(std::vector<Item>* out, size_t depth) {
        const Word keyword = peek().word;
        if (depth + 1 >= kMostDepth)
            return fail(keyword, fmt::format("`when` stands in `when` {} deep", kMostDepth));
        When when;
        bool more = true;
        while (more) {
            When::Branch& branch = when.branches.emplace_back();
            if (accept("when")) {
                if (!condition(&branch.condition.emplace(), 0)) return false;
            }
            more = branch.condition.has_value();
            if (!expect("{", "before the lines that depend on it")) return false;
            if (!block(&branch.items, depth + 1)) return false;
            if (!expect("}", "after the lines that depend on `when`")) return false;
            // `else` stands behind the `}`.
            more = more && accept("else");
        }
        out->push_back({std::move(when)});
        return true;
    }

    /// `a and b or not c`: `or` binds least.
    bool condition(Condition* out, int level) {
        if (level == 2) return simple_condition(out);
        const char* const word = level == 0 ? "or" : "and";
        Condition first;
        if (!condition(&first, level + 1)) return false;
        if (!peek().is(word)) {
            *out = std::move(first);
            return true;
        }
        out->kind = level == 0 ? Condition::Kind::kOr : Condition::Kind::kAnd;
        out->conditions.push_back(std::move(first));
        while (accept(word)) {
            if (!condition(&out->conditions.emplace_back(), level + 1)) return false;
        }
        return true;
    }

    bool simple_condition(Condition* out) {
        bool negated = false;
        while (accept("not"))
            negated = !negated;
        if (negated) {
            out->kind = Condition::Kind::kNot;
            out = &out->conditions.emplace_back();
        }
        Word left;
        if (!expect_word("a target or a parameter after `when`", &left)) return false;
        out->words.push_back(left);
        if (is_comparison()) {
            out->kind = Condition::Kind::kCompare;
            out->words.push_back(take().word);
            return expect_word("a number or a parameter", &out->words.emplace_back());
        }
        const std::vector<std::string>& known = targets();
        if (std::find(known.begin(), known.end(), left.text) == known.end()) {
            return fail(left, fmt::format("no target is called `{}`", left.text),
                        near_or_all(left.text, known, "there are"));
        }
        return true;
    }

    bool is_comparison() const {
        const auto& marks = kComparisons;
        return std::any_of(std::begin(marks), std::end(marks),
                           [&](const char* mark) { return peek().is(mark); });
    }

    bool line(std::vector<Item>* out) {
        Line line;
        if (!expect_word("the name of a func", &line.func)) return false;
        const std::string& name = line.func.text;
        if (name.find('*') < name.size() - 1)
            return fail(line.func, "`*` stands at the end of a name, for all that begin so");
        while (accept(".")) {
            if (!directive(&line.directives.emplace_back())) return false;
        }
        if (line.directives.empty()) {
            return fail(line.func, fmt::format("`{}` has no directive", name),
                        "write one after a dot, as in `weights.vectorize(z)`");
        }
        if (!at_end_of_line() && !peek().is("}"))
            return fail(peek().word, "expected `.` or the end of the line");
        out->push_back({std::move(line)});
        return true;
    }

    bool directive(Directive* out) {
        if (!expect_word("a directive after `.`", &out->name)) return false;
        const DirectiveRule* rule = find_rule(out->name.text);
        if (rule == nullptr) return refuse(out->name);
        if (!expect("(", "after a directive's name")) return false;
        const bool is_condition = !rule->args.empty() && rule->args[0] == ArgKind::kCondition;
        if (is_condition) return loop_condition(*rule, out);
        while (!peek().is(")")) {
            if (!out->args.empty() && !expect(",", "or `)` after an argument")) return false;
            if (!expect_word("a name or a number", &out->args.emplace_back())) return false;
        }
        take();
        const size_t count = out->args.size();
        if (count < rule->least_args || (!rule->any_number && count > rule->args.size())) {
            return fail(out->name,
                        fmt::format("`{}` with {} argument{}", out->name.text, count,
                                    count == 1 ? "" : "s"),
                        fmt::format("its form is `{}`", rule->form));
        }
        return true;
    }

    /// `n >= 16` or `n % 4 == 0`.
    bool loop_condition(const DirectiveRule& rule, Directive* out) {
        const std::string form = fmt::format("its form is `{}`", rule.form);
        if (!expect_word("the var whose length decides", &out->args.emplace_back())) return false;
        if (peek().is("%")) {
            out->args.push_back(take().word);
            if (!expect_word("a number", &out->args.emplace_back())) return false;
        }
        if (!is_comparison()) return fail(peek().word, "expected a comparison", form);
        out->args.push_back(take().word);
        return expect_word("a number", &out->args.emplace_back()) &&
               expect(")", "after the condition");
    }

    bool refuse(const Word& name) {
        if (const std::string why = why_refused(name.text); !why.empty()) {
            return fail(name, fmt::format("`{}` is not allowed in a schedule", name.text), why);
        }
        return fail(name, fmt::format("no directive is called `{}`", name.text),
                    near_or_all(name.text, directive_names(), "there are"));
    }

    static constexpr const char* kComparisons[] = {"<", ">", "<=", ">=", "==", "!="};

    const Source& source_;
    Parsing* all_;
    std::vector<Token> tokens_;
    size_t at_ = 0;
    File file_;
    Fault fault_;
};

}  // namespace

Fault fault_at(const Word& word, std::string message, std::string help) {
    Fault fault;
    fault.message = std::move(message);
    fault.help = std::move(help);
    fault.file = word.file;
    fault.line = word.line;
    fault.column = word.column;
    fault.offset = word.offset;
    fault.length = word.length;
    return fault;
}

std::variant<File, Fault> parse(const Source& source, const OpenFile& open) {
    Parsing all{open, {source.path}};
    return Parser(source, &all).run();
}

}  // namespace openfab::schedule
