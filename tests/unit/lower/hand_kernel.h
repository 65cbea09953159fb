// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A small kernel written by hand, with one Func of every sort that schedules meet.

#include "compiler/lower/algorithm/kernel.h"

namespace openfab::testing {

/// out(x 8, n), from `near`, which reads `base` beside it, from `base` itself, from `sum`, a
/// reduction over r_x (4) and r_y (3) of `base`, and from `answer`, which the runtime computes from
/// `asked`. Calls `openfab_hand_answer`.
inline lower::Kernel make_hand_kernel() {
    using namespace Halide;
    Var x("x"), n("n");
    ImageParam in(Float(32), 2, "in");
    Func base("base"), near("near"), sum("sum"), asked("asked"), answer("answer"), out("out");
    base(x, n) = in(clamp(x, 0, 7), n) * 2.0f;
    near(x, n) = base(x, n) + base(x + 1, n);
    RDom r(0, 4, 0, 3, "r");
    sum(x, n) = 0.0f;
    sum(x, n) += base(x, n) * cast<float>(r.x + 3 * r.y);
    asked(x, n) = in(clamp(x, 0, 7), n) + 1.0f;
    answer.define_extern("openfab_hand_answer", {asked}, Float(32), {x, n}, NameMangling::C);
    answer.compute_root();
    asked.compute_root();
    out(x, n) = near(x, n) + base(x, n) + sum(x, n) + answer(x, n);
    out.bound(x, 0, 8);
    out.output_buffer().dim(0).set_bounds(0, 8);
    out.output_buffer().dim(1).set_min(0);
    in.dim(0).set_bounds(0, 8);
    in.dim(1).set_min(0);
    const std::vector<std::pair<std::string, Var>> vars = {{"x", x}, {"n", n}};
    return {out,
            {in},
            {{"out", out, vars},
             {"near", near, vars},
             {"sum", sum, vars},
             {"base", base, vars},
             {"answer", answer, vars},
             {"asked", asked, vars}}};
}

}  // namespace openfab::testing
