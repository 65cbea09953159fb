// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Schedules against a kernel: what each directive may not do, and where it is reported.

#include "compiler/lower/schedule/apply_schedule.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "base/messages.h"
#include "compiler/lower/schedule/kernel_memory.h"
#include "compiler/lower/schedule/print_loops.h"
#include "tests/unit/lower/hand_kernel.h"

namespace openfab::lower {

namespace {

constexpr int64_t kPlaces = 1024;

std::string shown(const schedule::Fault& fault, const std::string& text) {
    const std::string marked = text.substr(fault.offset, static_cast<size_t>(fault.length));
    return std::to_string(fault.line) + ":" + std::to_string(fault.column) + " |" + marked + "| " +
           fault.message + (fault.help.empty() ? "" : "; " + fault.help);
}

struct Applied {
    std::string fault;
    std::string loops;
    std::optional<KernelMemory> memory;
};

Applied apply(const std::string& text) {
    auto parsed = schedule::read({"hand.sched", text});
    if (const auto* bad = std::get_if<schedule::Fault>(&parsed)) return {shown(*bad, text), {}, {}};
    const auto& schedule = std::get<schedule::Schedule>(parsed);
    const Kernel kernel = testing::make_hand_kernel();
    auto applied = apply_schedule(schedule, kernel);
    if (const auto* bad = std::get_if<schedule::Fault>(&applied))
        return {shown(*bad, text), {}, {}};
    const auto& scheduled = std::get<ScheduledKernel>(applied);
    try {
        using Halide::Target;
        const Target target(Target::Linux, Target::X86, 64,
                            {Target::SSE41, Target::StrictFloat, Target::NoRuntime});
        const Halide::Module module =
            Halide::Pipeline(kernel.output).compile_to_module(kernel.arguments, "hand", target);
        const auto memory = check_lowered(schedule, scheduled, module, kPlaces);
        if (const auto* bad = std::get_if<schedule::Fault>(&memory))
            return {shown(*bad, text), {}, {}};
        return {"accepted", print_loops(scheduled, list_storage(scheduled, module, kPlaces)),
                std::get<KernelMemory>(memory)};
    } catch (const Halide::Error& error) {
        return {"late " + shown(fault_of_lowering(schedule, scheduled, error.what()), text) +
                    " <- " + error.what(),
                {},
                {}};
    }
}

TEST(ApplySchedule, AcceptsEveryDirective) {
    for (const char* text : {
             "out.vectorize(x)",
             "out.split(n, no, ni, 3).reorder(x, ni, no).unroll(ni).parallel(no).vectorize(x, 4)",
             "out.tile(x, n, xo, no, xi, ni, 4, 4).fuse(xo, no, t).parallel(t).vectorize(xi)",
             "out.split(x, xo, xi, 3).vectorize(xi)",
             "base.compute_at(out, n)\nout.split(n, no, n, 4).split(x, x, xi, 2).vectorize(xi)",
             "base.compute_root().store_in(heap).reorder_storage(n, x).vectorize(x, 4)",
             "base.compute_at(out, n).align_storage(x, 16).store_in(stack)",
             "near.compute_at(out, n)\nbase.compute_at(out, n).vectorize(x, 3)",
             "base.compute_root().compute_inline()",
             "sum.compute_at(out, n).vectorize(x).update().vectorize(x).unroll(r_x)",
             "sum.compute_at(out, n).update().reorder(r_x, x, r_y).split(r_x, a, b, 3).unroll(b)",
             "sum.compute_at(out, n).update(0).reorder(x, r_x, r_y)",
             "out.split(n, no, ni, 8)\nbase.store_at(out, no).compute_at(out, ni)",
             "base.store_root().compute_at(out, n)",
             "base.store_root().compute_at(out, x).fold_storage(x, 2)",
             "answer.compute_at(out, n)\nasked.compute_at(out, n).vectorize(x, 4)",
             "out.specialize(n >= 16).split(n, no, ni, 4).parallel(no)\nout.vectorize(x)",
             "out.specialize(n % 4 == 0).unroll(n, 4)",
             "base.compute_root()\nout.prefetch(base, n, 2)",
             "base.compute_at(out, n).bound_storage(x, 9)",
             "out.vectorize(x, 2).unroll(x, 2).unroll(x, 2)",
         }) {
        EXPECT_EQ(apply(text).fault, "accepted") << text;
    }
}

TEST(ApplySchedule, MarksWhatADirectiveMayNotDo) {
    const std::map<std::string, std::string> cases = {
        // Names.
        {"ouut.vectorize(x)", "1:1 |ouut| this kernel has no func `ouut`; " +
                                  fmt::format(openfab::messages::kDidYouMean, "out")},
        {"out.vectorize(q)", "1:15 |q| `out` has no var `q`; it has x, n"},
        {"out.split(n, x, ni, 2)", "1:14 |x| `out` has, or had, a var `x` already"},
        {"out.split(n, no, no, 2)", "1:18 |no| `out` has, or had, a var `no` already"},
        {"out.split(n, n, n, 2)", "1:17 |n| `out` has, or had, a var `n` already"},
        {"out.split(n, 4, ni, 2)", "1:14 |4| `4` cannot name a var"},
        {"out.split(n, no, ni, 2).parallel(n)", "1:34 |n| `out` has no var `n`; it has x, ni, no"},
        {"out.split(n, no, ni, 0)", "1:22 |0| expected a number from 1 to 4096"},
        // Loops.
        {"out.vectorize(x).unroll(x)", "1:25 |x| `x` is vectorized already"},
        {"out.vectorize(n)",
         "1:15 |n| the length of `n` is known only when the kernel runs; give a factor, as in "
         "`vectorize(n, 8)`"},
        {"out.unroll(n)",
         "1:12 |n| the length of `n` is known only when the kernel runs; give a factor, as in "
         "`unroll(n, 8)`"},
        {"out.vectorize(n, 65)", "1:18 |65| expected a number from 1 to 64"},
        {"out.vectorize(x).vectorize(n, 16)",
         "1:28 |n| this makes vectors of 128 lanes; the limit is 64"},
        {"out.unroll(x).unroll(n, 17)",
         "1:22 |n| this makes 136 copies of the code; the limit is 128"},
        {"out.reorder(x, x)", "1:16 |x| `x` is named twice"},
        {"out.fuse(x, x, t)", "1:13 |x| one loop cannot be fused with itself"},
        {"out.tile(x, x, a, b, c, d, 2, 2)", "1:13 |x| the sides of a tile are two vars"},
        // Reductions.
        {"sum.compute_at(out, n).update().reorder(r_y, r_x)",
         "1:41 |r_y| `r_y` runs over a reduction: in another order its result would be another; "
         "its "
         "loops can be split, unrolled, and stand inside or outside others"},
        {"sum.compute_at(out, n).update().split(r_x, a, b, 2).reorder(a, x, b)",
         "1:61 |a| `a` runs over a reduction: in another order its result would be another; its "
         "loops can be split, unrolled, and stand inside or outside others"},
        {"sum.compute_at(out, n).update().vectorize(r_x)",
         "1:43 |r_x| `r_x` runs over a reduction: its steps come one after the other; vectorize a "
         "var of the func"},
        {"sum.compute_at(out, n).update().parallel(r_x)",
         "1:42 |r_x| `r_x` runs over a reduction: its steps come one after the other; make a var "
         "of "
         "the func parallel"},
        {"sum.compute_at(out, n).update().fuse(r_x, x, t)",
         "1:38 |r_x| `r_x` runs over a reduction: in another order its result would be another; "
         "its "
         "loops can be split, unrolled, and stand inside or outside others"},
        {"base.update()", "1:6 |update| `base` has no loop to update"},
        {"sum.update(1)", "1:12 |1| `sum` has 1 update, counted from 0"},
        {"sum.update().compute_root()",
         "1:14 |compute_root| this is about the whole func: it belongs before `update()`"},
        // Places.
        {"out.compute_root()",
         "1:5 |compute_root| `out` is the kernel's result and stays outermost"},
        {"base.compute_at(base, x)", "1:17 |base| a func is computed inside another"},
        {"near.compute_at(base, x)",
         "1:6 |compute_at| `base` does not read `near`; a func is computed inside a loop of one "
         "that reads it: `out`"},
        {"base.compute_at(near, x)",
         "1:6 |compute_at| `near` is inline: it has no loops of its own; place `near` first, or "
         "choose one that reads it"},
        {"near.compute_at(out, n)\nbase.compute_at(near, x)",
         "2:6 |compute_at| `out` reads `base` too, outside the loop `x` of `near`; "
         "`compute_at(out, "
         "n)` is around all that reads it"},
        {"base.compute_at(out, n)\nout.split(n, no, ni, 2)",
         "1:6 |compute_at| `out` has no var `n` after all lines; it has x, ni, no"},
        {"base.compute_at(out, x)\nout.vectorize(x)",
         "1:6 |compute_at| the loop `x` of `out` is vectorized: nothing is computed inside it; "
         "choose a loop outside it"},
        {"base.compute_at(out, n)\nout.specialize(n > 8).split(n, no, ni, 2)",
         "1:6 |compute_at| the specialization `n > 8` of `out`, which reads `base`, has no loop "
         "`n`"},
        {"base.compute_at(out, n)\nout.specialize(n > 8).vectorize(n, 4)", "accepted"},
        {"base.compute_at(out, x)\nout.specialize(n > 8).vectorize(x)",
         "1:6 |compute_at| the loop `x` of `out` if n > 8 is vectorized: nothing is computed "
         "inside "
         "it; choose a loop outside it"},
        {"base.store_root().compute_at(out, n)\nout.specialize(n > 8).parallel(n)",
         "1:6 |store_root| the loop `n` of `out` if n > 8, between where `base` is stored and "
         "where "
         "it is computed, is parallel: threads would write over each other; store it inside that "
         "loop"},
        {"base.store_at(out, n).compute_at(out, x)\nout.specialize(n > 8).reorder(n, x)",
         "1:6 |store_at| the loop `n` of `out` is not around `x` if n > 8"},
        {"base.store_root()",
         "1:6 |store_root| `base` is inline: nothing of it is stored; say where it is computed: "
         "compute_at, compute_root"},
        {"near.compute_at(out, n)\nbase.compute_root().store_at(out, n)",
         "2:21 |store_at| `base` is not computed inside the loop `n` of `out`; a func is stored "
         "where it is computed, or in a loop outside"},
        {"out.parallel(n)\nbase.store_root().compute_at(out, n)",
         "2:6 |store_root| the loop `n` of `out`, between where `base` is stored and where it is "
         "computed, is parallel: threads would write over each other; store it inside that loop"},
        {"near.vectorize(x)",
         "1:1 |near| `near` is part of what reads it, so it has no loops that are vectorized, "
         "unrolled, parallel or split; place it, as in `near.compute_at(func, var)`"},
        {"near.compute_root().split(n, no, ni, 2).compute_inline()",
         "1:41 |compute_inline| `near` is part of what reads it, so it has no loops that are "
         "vectorized, unrolled, parallel or split; place it, as in `near.compute_at(func, var)`"},
        {"sum.compute_inline()", "1:5 |compute_inline| `sum` has updates: it has to be stored"},
        {"asked.compute_inline()",
         "1:7 |compute_inline| `asked` is read by the runtime: it has to be stored; place it: "
         "compute_at, compute_root"},
        {"answer.vectorize(x)",
         "1:8 |vectorize| `answer` is computed by the runtime: it has no loops of its own; it can "
         "be placed: compute_at, compute_root, store_at, store_root"},
        {"asked.compute_at(answer, x)",
         "1:18 |answer| `answer` is computed by the runtime: it has no loops of its own; it can be "
         "placed: compute_at, compute_root, store_at, store_root"},
        // Storage.
        {"out.align_storage(x, 8)",
         "1:5 |align_storage| `out` is the kernel's result: the buffer is the caller's"},
        {"answer.reorder_storage(n, x)",
         "1:8 |reorder_storage| the runtime writes `answer` and knows its layout"},
        {"asked.align_storage(x, 16)",
         "1:7 |align_storage| the runtime reads `asked` and knows its layout"},
        {"base.store_in(gpu)", "1:15 |gpu| expected `heap` or `stack`"},
        {"base.compute_root().align_storage(q, 8)",
         "1:35 |q| the storage of `base` has no dimension `q`; it has x, n"},
        {"base.compute_at(out, n).bound_storage(x, 4)",
         "1:25 |bound_storage| it is not certain that this holds all of `base` that is in use at a "
         "time; make it larger; without it, what is stored is right by itself"},
        {"out.reorder(n, x)\nbase.store_root().compute_at(out, x).fold_storage(x, 1)",
         "2:38 |fold_storage| it is not certain that this holds all of `base` that is in use at a "
         "time; make it larger; without it, what is stored is right by itself"},
        // Others.
        {"out.prefetch(asked, n, 2)", "1:14 |asked| `out` does not read `asked`"},
        {"base.compute_at(out, n)\nout.prefetch(base, n, 2)",
         "2:5 |prefetch| `base` is not stored before the loop `n` of `out`; what is fetched early "
         "is "
         "what a loop outside has computed"},
        {"out.prefetch(base, n, 2)",
         "1:5 |prefetch| `base` is not stored before the loop `n` of `out`; what is fetched early "
         "is "
         "what a loop outside has computed"},
        {"out.vectorize(x).prefetch(base, x, 2)",
         "1:33 |x| `x` is vectorized: it has no next step"},
        {"base.specialize(n > 2)",
         "1:6 |specialize| `base` is not a result of the kernel: no var of it has a length that is "
         "known before"},
        {"out.specialize(q > 2)", "1:16 |q| the kernel's result has no var `q`; it has x, n"},
        {"out.specialize(n > 2).specialize(n > 4)",
         "1:23 |specialize| a specialization is not specialized again"},
    };
    for (const auto& [text, expected] : cases)
        EXPECT_EQ(apply(text).fault, expected) << text;
}

// Beyond these limits Halide's time grows with the third power of the lines.
TEST(ApplySchedule, LimitsVarsAndVersions) {
    const auto repeated = [](int times, const std::string& line) {
        std::string text = "near.compute_root()\n";
        for (int k = 0; k < times; ++k)
            text += fmt::format(fmt::runtime(line), k) + "\n";
        return apply(text).fault;
    };
    const std::string vars = "`near` has, or had, 64 vars here, which is the limit";
    // It has two before any line.
    const std::string splits = "near.split(n, c{0}, n, 1)";
    EXPECT_EQ(repeated(62, splits), "accepted");
    EXPECT_EQ(repeated(63, splits), "64:15 |c62| " + vars);
    EXPECT_EQ(repeated(3000, splits), "64:15 |c62| " + vars);
    EXPECT_EQ(repeated(3000, "near.unroll(n, 1)"), "64:13 |n| " + vars);
    EXPECT_EQ(repeated(3000, "near.vectorize(x, 1)"), "64:16 |x| " + vars);
    EXPECT_EQ(repeated(16, "out.specialize(n >= {0})"), "accepted");
    EXPECT_EQ(repeated(3000, "out.specialize(n >= {0})"),
              "18:5 |specialize| `out` has 16 specializations, which is the limit");
}

TEST(ApplySchedule, NeverShowsHalidesWords) {
    // Only lowering tells that the length is not constant.
    const std::string text = "base.compute_root().vectorize(n)";
    const Applied late = apply(text);
    EXPECT_EQ(
        late.fault.substr(0, late.fault.find(" <- ")),
        "late 1:21 |vectorize| a loop of `base` has no constant length; only loops of constant "
        "length can be vectorized or unrolled; give a factor, as in `vectorize(n, 8)`");
}

TEST(ApplySchedule, RefusesWhatGrowsByInlining) {
    // Each of 20 Funcs reads the one before it three times.
    const auto make = [] {
        const Halide::Var x("x");
        Kernel kernel;
        Halide::Func last("f0");
        last(x) = Halide::cast<float>(x);
        kernel.funcs.push_back({"f0", last, {{"x", x}}});
        for (int k = 1; k <= 20; ++k) {
            const std::string name = "f" + std::to_string(k);
            Halide::Func next(name);
            next(x) = last(x) * last(x - 1) + last(x + 1);
            last = next;
            kernel.funcs.insert(kernel.funcs.begin(), {name, last, {{"x", x}}});
        }
        kernel.output = last;
        return kernel;
    };
    const auto check = [&](const std::string& text) {
        auto parsed = schedule::read({"f.sched", text});
        auto applied = apply_schedule(std::get<schedule::Schedule>(parsed), make());
        const auto* fault = std::get_if<schedule::Fault>(&applied);
        return fault == nullptr ? std::string("accepted") : shown(*fault, text);
    };
    EXPECT_EQ(check("f20.vectorize(x, 8)").substr(0, 40),
              "1:1 |f20| `f19` is part of `f20`, which ");
    EXPECT_EQ(check("f20.vectorize(x, 8)\nf10.compute_root()"), "accepted");
    // Of a schedule without a line the file is to blame.
    auto empty = schedule::read({"f.sched", "# nothing", 3});
    auto applied = apply_schedule(std::get<schedule::Schedule>(empty), make());
    ASSERT_TRUE(std::holds_alternative<schedule::Fault>(applied));
    EXPECT_EQ(std::get<schedule::Fault>(applied).file, 3u);
    EXPECT_EQ(std::get<schedule::Fault>(applied).line, 1);
}

// Halide takes the bounds of the loop `r_x` from `limit` before the loop begins.
TEST(ApplySchedule, WhatDecidesTheStepsOfAReductionIsComputedOutsideIt) {
    const auto make = [] {
        const Halide::Var x("x"), n("n");
        Halide::ImageParam in(Halide::Float(32), 1, "in");
        Halide::Func near("near"), limit("limit"), sum("sum"), out("out");
        near(n) = in(n);
        limit(n) = Halide::cast<int>(near(n));
        Halide::RDom r(0, 4, "r");
        r.where(r < limit(n));
        sum(x, n) = 0.0f;
        sum(x, n) += Halide::cast<float>(r.x);
        sum.update().reorder(x, r);
        out(x, n) = sum(x, n);
        const std::vector<std::pair<std::string, Halide::Var>> vars = {{"x", x}, {"n", n}};
        return Kernel{out,
                      {in},
                      {{"out", out, vars},
                       {"sum", sum, vars},
                       {"limit", limit, {{"n", n}}},
                       {"near", near, {{"n", n}}}}};
    };
    const auto check = [&](const std::string& text) {
        auto parsed = schedule::read({"f.sched", "sum.compute_at(out, n)\n" + text});
        auto applied = apply_schedule(std::get<schedule::Schedule>(parsed), make());
        const auto* fault = std::get_if<schedule::Fault>(&applied);
        return fault == nullptr ? std::string("accepted") : fault->message + "; " + fault->help;
    };
    EXPECT_EQ(check("limit.compute_at(sum, n)"), "accepted");
    EXPECT_EQ(check("limit.store_at(out, n).compute_at(sum, x)"),
              "`limit` decides which steps the loop `r_x` of `sum` has: it is not computed inside "
              "it; choose a loop outside it");
    EXPECT_EQ(check("near.compute_at(sum, x)"),
              "`near` decides which steps the loop `r_x` of `sum` has: it is not computed inside "
              "it; choose a loop outside it");
    EXPECT_EQ(check("limit.compute_at(out, n)\nnear.compute_at(out, x)"),
              "`limit` reads `near` too, outside the loop `x` of `out`; `compute_at(limit, n)` is "
              "around all that reads it");
}

TEST(ApplySchedule, CountsWhatIsStored) {
    // 8 floats of `sum`, of `answer` and of `asked`; 9 of `base`.
    const Applied inner = apply(
        "answer.compute_at(out, n)\nasked.compute_at(out, n)\nbase.compute_at(out, n)\n"
        "sum.compute_at(out, n)");
    ASSERT_TRUE(inner.memory) << inner.fault;
    EXPECT_GE(inner.memory->bytes, 33 * 4);
    EXPECT_LE(inner.memory->bytes, 64 * 4);
    const Applied root = apply(
        "answer.compute_at(out, n)\nasked.compute_at(out, n)\nbase.compute_root()\n"
        "sum.compute_at(out, n)");
    ASSERT_TRUE(root.memory) << root.fault;
    EXPECT_GE(root.memory->bytes, 9 * 4 * kPlaces + 24 * 4);
    EXPECT_LE(root.memory->bytes, 9 * 4 * kPlaces + 64 * 4);
    // What each thread of a parallel loop stores is counted too.
    const Applied parallel = apply(
        "out.parallel(n)\nanswer.compute_at(out, n)\nasked.compute_at(out, n)\n"
        "base.compute_at(out, n)\nsum.compute_at(out, n)");
    ASSERT_TRUE(parallel.memory) << parallel.fault;
    EXPECT_GE(parallel.memory->bytes, 33 * 4);
    EXPECT_LE(parallel.memory->bytes, 64 * 4);
}

TEST(ApplySchedule, RefusesWhatStoresMoreThanAPlanAllows) {
    // 9 floats of 1024 places, each of which takes 4096 floats.
    EXPECT_EQ(apply("base.compute_root().align_storage(x, 4096)").fault, "accepted");
    EXPECT_EQ(
        apply("base.compute_root().align_storage(x, 4096).align_storage(n, 4096)").fault,
        "1:6 |compute_root| this schedule stores up to 64.1 MiB for a thread, `base` the most "
        "of it; the limit is 64.0 MiB; compute it at an inner loop");
    EXPECT_EQ(apply("base.compute_at(out, n).store_in(stack).align_storage(x, 4096)\n"
                    "near.compute_at(out, n).store_in(stack).align_storage(x, 4096)")
                  .fault,
              "accepted");
}

TEST(ApplySchedule, PrintsLoopsInOurNames) {
    const Applied applied = apply(
        "out.split(n, no, ni, 4).vectorize(x, 4)\n"
        "answer.compute_at(out, no)\nasked.compute_at(out, no)\n"
        "base.store_at(out, no).compute_at(out, ni).vectorize(x, 4)\n"
        "sum.compute_at(out, ni).update().unroll(r_x)");
    ASSERT_EQ(applied.fault, "accepted");
    EXPECT_EQ(applied.loops,
              "out:\n"
              "  for no:\n"
              "    store asked: 32768 bytes\n"  // an upper bound, of the whole call
              "    store answer: 128 bytes\n"
              "    store base: 36 bytes\n"
              "    asked:\n"
              "      for n:\n"
              "        for x:\n"
              "          asked = …\n"
              "    answer: computed by the runtime\n"
              "    for ni in 4:\n"
              "      store sum: 32 bytes\n"
              "      base:\n"
              "        for n:\n"
              "          for x:\n"
              "            vectorized x_vectorize in 4:\n"
              "              base = …\n"
              "      sum:\n"
              "        for n:\n"
              "          for x:\n"
              "            sum = …\n"
              "      sum, update 0:\n"
              "        for n:\n"
              "          for x:\n"
              "            for r_y in 3:\n"
              "              unrolled r_x in 4:\n"
              "                sum = …\n"
              "      for x in 2:\n"
              "        vectorized x_vectorize in 4:\n"
              "          out = …\n"
              "near: computed where it is read\n");
}

}  // namespace

}  // namespace openfab::lower
