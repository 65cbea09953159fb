// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Measures the functions of the standard library and writes the figures into their table, which the
// site shows beside each of them:
//   bench_library stdlib/costs.json [FUNCTION …]
// Without names, all. A row has its module, the function's signature and a call of it, written by
// hand; the figures are this program's. A row without a call keeps its note.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/json_text.h"
#include "base/say.h"
#include "bench/library/measure.h"

namespace openfab::bench {

namespace {

std::string text_of(const JsonValue& row, std::string_view key) {
    const JsonValue* found = member_of(row, key);
    return found == nullptr ? "" : found->text;
}

double rounded(double value, double steps) {
    return std::round(value * steps) / steps;
}

/// Three digits of it, at most two of them behind the point.
double rounded(double value) {
    return rounded(value, value >= 100 ? 1 : (value >= 10 ? 10 : 100));
}

std::string processor() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "unknown";
}

/// The row with its figures.
std::string measured(const JsonValue& row) {
    const std::string signature = text_of(row, "function");
    const testing::LibraryCall sample{
        text_of(row, "module"),
        text_of(row, "module") == "dither" ? "rule" : signature.substr(0, signature.find(' ')),
        text_of(row, "call")};
    const Figures figures = measure(sample);
    JsonText out;
    out.begin_object();
    out.member("module", sample.module).member("function", signature).member("call", sample.call);
    out.member("ns", rounded(std::max(figures.cost.ns, 0.0)));
    out.member("spread", rounded(figures.cost.spread));
    out.member("copies", rounded(figures.cost.copies, 10));
    const Bounds& bounds = figures.bounds;
    if (sample.type != "rule") out.member("bounded", bounds.known);
    if (bounds.width) out.member("width", rounded(*bounds.width));
    if (bounds.one_sided && bounds.known) {
        out.member("one_sided", rounded(*bounds.one_sided, 1000));
        out.member("decided", rounded(*bounds.decided, 1000));
    }
    out.end_object();
    fmt::print("{}\n", out.take());
    return out.take();
}

std::string as_it_is(const JsonValue& row) {
    return JsonText().value(row).take();
}

Result<void> run(const std::string& file, const std::vector<std::string>& names) {
    const Result<std::string> text = read_text_file(file, 1'000'000);
    if (!text) return text.error();
    const Result<JsonValue> table = parse_json(*text, file);
    if (!table) return table.error();
    const JsonValue* rows = member_of(*table, "functions");
    if (rows == nullptr) return user_error(fmt::format("`{}` has no `functions`", file));
    std::vector<std::string> lines;
    for (const JsonValue& row : rows->items) {
        const std::string signature = text_of(row, "function");
        const size_t begin = signature.find(' ') + 1;
        const std::string name = signature.substr(begin, signature.find('(') - begin);
        const bool wanted = names.empty() || std::ranges::find(names, name) != names.end();
        const bool has_call = !text_of(row, "call").empty();
        lines.push_back("  " + (wanted && has_call ? measured(row) : as_it_is(row)));
    }
    std::ofstream out(file, std::ios::trunc);
    out << "{\n \"processor\": " << JsonText().value(processor()).take()
        << ",\n \"rounds\": " << kRounds << ",\n \"functions\": [\n"
        << fmt::format("{}", fmt::join(lines, ",\n")) << "\n ]\n}\n";
    if (!out.flush()) return outside_error(fmt::format("cannot write `{}`", file));
    return {};
}

}  // namespace

}  // namespace openfab::bench

int main(int argc, char** argv) {
    openfab::prepare_streams();
    if (argc < 2) {
        openfab::say("usage: bench_library stdlib/costs.json [FUNCTION ...]\n");
        return 2;
    }
    const openfab::Result<void> done = openfab::bench::run(argv[1], {argv + 2, argv + argc});
    return done ? 0 : openfab::say_error(done.error());
}
