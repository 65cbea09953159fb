// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "compiler/check/check.h"
#include "compiler/check/fablet_checker.h"

namespace openfab::check {

/// Checks modules and the program: the top of the checker, private to compiler/check.
class Checker {
  public:
    Checker(const CheckOptions& options, Program* program, diag::Sink* sink)
        : sink_(sink),
          program_(*program),
          names_(sink, options.uses),
          unknown_(sink, names_, place_, options.module_of),
          expressions_(sink, &names_, place_, &unknown_, &program->structs),
          statements_(sink, &names_, place_, &expressions_),
          declarations_(sink, &names_, &place_, &unknown_, &expressions_, &statements_),
          fablets_(sink, &names_, &place_, &unknown_, &expressions_, &statements_, &declarations_) {
    }
    void run(const std::vector<Unit>& units, const CheckOptions& options);

  private:
    /// The names that a module exports.
    struct Exports {
        Names::Scope names;
        std::vector<const Function*> functions;
    };

    void check_unit(const Unit& unit, std::vector<Exports>* done);
    void import_names(const Unit& unit, const std::vector<Exports>& done);
    void check_fablets(const ast::File& file);
    void find_rule(const Unit& unit, const Exports& exports, const std::string& name);

    diag::Sink* sink_;
    Program& program_;
    Place place_;
    Names names_;
    UnknownNames unknown_;
    ExpressionChecker expressions_;
    StatementChecker statements_;
    Declarations declarations_;
    FabletChecker fablets_;
};

}  // namespace openfab::check
