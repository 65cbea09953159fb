// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <optional>

#include "base/near_miss.h"
#include "compiler/lower/default_schedules.h"

namespace openfab::lower {

namespace {

struct Rule {
    const char* name;
    int least_args;
    int most_args;  ///< -1: any number
    const char* form;
};

constexpr Rule kRules[] = {
    {"split", 4, 4, "split(var, outer, inner, factor)"},
    {"tile", 8, 8, "tile(x, y, xo, yo, xi, yi, factor_x, factor_y)"},
    {"fuse", 3, 3, "fuse(inner, outer, fused)"},
    {"reorder", 2, -1, "reorder(innermost, …, outermost)"},
    {"unroll", 1, 2, "unroll(var[, factor])"},
    {"vectorize", 1, 2, "vectorize(var[, factor])"},
    {"parallel", 1, 1, "parallel(var)"},
    {"compute_at", 2, 2, "compute_at(func, var)"},
    {"compute_root", 0, 0, "compute_root()"},
    {"store_at", 2, 2, "store_at(func, var)"},
    {"store_root", 0, 0, "store_root()"},
    {"update", 0, 0, "update()"},
};

constexpr const char* kRefused[] = {"rfactor", "atomic",      "allow_race_conditions",
                                    "memoize", "approximate", "fold_storage",
                                    "async"};

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

class Parser {
  public:
    Parser(std::string path, std::string_view text) {
        out_.path = std::move(path);
        out_.text = text;
    }

    std::variant<Schedule, ScheduleFault> run() {
        size_t begin = 0;
        const std::string& text = out_.text;
        for (line_ = 1; begin < text.size(); ++line_) {
            size_t end = text.find('\n', begin);
            if (end == std::string::npos) end = text.size();
            begin_ = at_ = begin;
            end_ = std::min(end, text.find('#', begin));
            skip_blanks();
            if (at_ < end_ && !line()) return fault_;
            begin = end + 1;
        }
        return std::move(out_);
    }

  private:
    char peek() const { return at_ < end_ ? out_.text[at_] : '\0'; }
    void skip_blanks() {
        while (at_ < end_ && std::isspace(static_cast<unsigned char>(out_.text[at_])) != 0)
            ++at_;
    }
    ScheduleWord mark(size_t from) const {
        return {out_.text.substr(from, at_ - from), static_cast<int32_t>(from - begin_) + 1, from};
    }
    bool fail(const ScheduleWord& where, std::string message, std::string help = {}) {
        fault_.message = std::move(message);
        fault_.help = std::move(help);
        fault_.line = line_;
        fault_.column = where.column;
        fault_.offset = where.offset;
        fault_.length = std::max<int32_t>(1, static_cast<int32_t>(where.text.size()));
        return false;
    }
    bool expect(char c, const char* after) {
        skip_blanks();
        if (peek() == c) {
            ++at_;
            return true;
        }
        return fail(mark(at_), fmt::format("expected `{}` after {}", c, after));
    }
    std::optional<ScheduleWord> word(bool star) {
        skip_blanks();
        const size_t from = at_;
        while (at_ < end_ && (is_word(out_.text[at_]) || (star && out_.text[at_] == '*')))
            ++at_;
        if (from == at_) return std::nullopt;
        return mark(from);
    }

    bool line() {
        ScheduleLine line;
        line.line = line_;
        std::optional<ScheduleWord> func = word(true);
        if (!func) return fail(mark(at_), "expected the name of a func");
        line.func = *func;
        skip_blanks();
        while (peek() == '.') {
            ++at_;
            Directive directive;
            if (!this->directive(&directive)) return false;
            line.directives.push_back(std::move(directive));
            skip_blanks();
        }
        if (line.directives.empty()) {
            return fail(line.func, fmt::format("`{}` has no directive", line.func.text),
                        "write one after a dot, as in `weights.vectorize(z)`");
        }
        if (at_ < end_) return fail(mark(at_), "expected `.` or the end of the line");
        out_.lines.push_back(std::move(line));
        return true;
    }

    bool directive(Directive* out) {
        std::optional<ScheduleWord> name = word(false);
        if (!name) return fail(mark(at_), "expected a directive after `.`");
        out->name = *name;
        const Rule* rule = std::find_if(std::begin(kRules), std::end(kRules),
                                        [&](const Rule& r) { return name->text == r.name; });
        if (rule == std::end(kRules)) return refuse(*name);
        if (!expect('(', "a directive's name")) return false;
        skip_blanks();
        while (peek() != ')') {
            if (!out->args.empty() && !expect(',', "an argument")) return false;
            std::optional<ScheduleWord> arg = word(false);
            if (!arg) return fail(mark(at_), "expected a name or a number");
            out->args.push_back(*arg);
            skip_blanks();
        }
        ++at_;
        const int count = static_cast<int>(out->args.size());
        if (count < rule->least_args || (rule->most_args >= 0 && count > rule->most_args)) {
            return fail(*name, fmt::format("`{}` with {} arguments", name->text, count),
                        fmt::format("its form is `{}`", rule->form));
        }
        return true;
    }

    bool refuse(const ScheduleWord& name) {
        for (const char* refused : kRefused) {
            if (name.text == refused) {
                return fail(
                    name, fmt::format("`{}` is not allowed in a schedule", name.text),
                    "a schedule says how a kernel runs; this could change what it computes");
            }
        }
        std::vector<std::string> names;
        for (const Rule& rule : kRules)
            names.emplace_back(rule.name);
        return fail(name, fmt::format("no directive is called `{}`", name.text),
                    near_or_all(name.text, names, "there are"));
    }

    Schedule out_;
    ScheduleFault fault_;
    int32_t line_ = 1;
    size_t begin_ = 0;
    size_t at_ = 0;
    size_t end_ = 0;
};

Schedule must_parse(const EmbeddedText& file) {
    std::variant<Schedule, ScheduleFault> parsed =
        parse_schedule(fmt::format("schedules/{}", file.name), file.text);
    if (const auto* fault = std::get_if<ScheduleFault>(&parsed)) {
        fmt::print(stderr, "{}:{}:{}: internal error: {}\n", file.name, fault->line, fault->column,
                   fault->message);
        std::abort();
    }
    return std::move(std::get<Schedule>(parsed));
}

}  // namespace

std::string near_or_all(std::string_view word, std::span<const std::string> names,
                        const char* all) {
    const std::string near = near_miss(word, names);
    return near.empty() ? fmt::format("{} {}", all, fmt::join(names, ", "))
                        : fmt::format("did you mean `{}`?", near);
}

std::variant<Schedule, ScheduleFault> parse_schedule(std::string path, std::string_view text) {
    return Parser(std::move(path), text).run();
}

const Schedule& default_schedule(std::string_view kernel, std::string_view target) {
    static const std::map<std::string, Schedule> parsed = [] {
        std::map<std::string, Schedule> out;
        for (const EmbeddedText& file : kSchedules)
            out[std::string(file.name)] = must_parse(file);
        return out;
    }();
    const auto special = parsed.find(fmt::format("{}.{}.sched", kernel, target));
    return special != parsed.end() ? special->second : parsed.at(fmt::format("{}.sched", kernel));
}

}  // namespace openfab::lower
