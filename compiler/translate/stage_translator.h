// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The translator of one stage, private to compiler/translate: statements and calls in
// translate_stmt.cpp, expressions in translate_expr.cpp, built-in functions in
// translate_builtin.cpp.

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/check.h"
#include "compiler/check/limits.h"
#include "compiler/diag/sink.h"
#include "compiler/translate/formulas.h"
#include "compiler/translate/paths.h"
#include "compiler/translate/translate.h"

namespace openfab::translate {

class StageTranslator : private Paths {
  public:
    StageTranslator(const check::Fablet& fablet, ir::StageKind kind, ir::Stage* out,
                    diag::Sink* sink)
        : Paths(out), fablet_(fablet), kind_(kind), stage_(out), sink_(sink) {}

    /// Translates the stage's own body with its outputs.
    void run(const check::Stage& stage, const TranslateOptions& options);
    /// Evaluates an expression outside a stage, such as a uniform's default: empty unless all its
    /// components are constants.
    std::vector<uint32_t> constant_bits(const check::Expr& expr);
    /// Translates a function in isolation, with unknown arguments; only the diagnostics are of use.
    void run(const check::Function& function);
    /// Returns the functions that were called.
    const std::set<const check::Function*>& inlined() const { return inlined_; }
    /// Returns the number of statements and calls that were translated.
    size_t steps() const { return steps_; }

  private:
    /// Components of a variable or value, selected where `condition` holds.
    struct Alternative {
        ir::ValueId condition = 0;  ///< kNoValue until make_conditions
        std::vector<size_t> lanes;
    };
    /// A varying index, of so many elements.
    struct VaryingIndex {
        ir::ValueId value = 0;
        size_t count = 0;
    };
    /// The target of an assignment or a selection: one of several alternatives, of which exactly
    /// one condition holds. Without alternatives after an error.
    struct Target {
        const check::Symbol* symbol = nullptr;  ///< the variable, or null: `value`
        Value value;
        std::vector<Alternative> alternatives;
        std::vector<VaryingIndex> indices;  ///< whose product is how many there are
    };
    /// One section of a `switch`.
    struct Section {
        ir::ValueId condition = 0;
        const check::Stmt* stmt = nullptr;
    };

    /// The state to roll back to when an attempt at a loop fails.
    struct Attempt {
        size_t instructions = 0;
        size_t printfs = 0;
        diag::Sink::Mark reported;
        std::vector<Variable> variables;
        std::vector<Branch> open;
        Frame frame;
        ir::ValueId live = 0;
        int inline_depth = 0;
    };
    /// A real loop before its end is emitted. The variables are in the order of `changes`.
    struct RealLoop {
        ir::ValueId loop = 0;
        ir::ValueId again = 0;
        ir::ValueId count = ir::kNoValue;  ///< iteration counter, after the variables; with @bound
        size_t vars = 0;                   ///< components
        Changes changes;
        std::map<VariableId, Value> assigned_before;  ///< at the start of any iteration
    };

    // translate_stmt.cpp
    bool skip_where_exited(std::vector<ir::ValueId>* pending);
    void statement(const check::Stmt& stmt);
    void statements(const std::vector<check::StmtPtr>& list);
    void declare(const check::Stmt& stmt);
    void return_statement(const check::Stmt& stmt);
    Value nested(const source::Span& span, const std::function<Value()>& body);
    Value inline_call(const check::Expr& expr);
    Value call(const check::Expr& expr);
    Value run_body(const check::Function& f, std::vector<Variable> arguments,
                   std::vector<Value>* results);
    Value call_result(const check::Function& f, const check::Type& type, int32_t number,
                      const std::vector<Variable>& arguments);
    void add_stage_symbol(const check::Symbol& symbol);
    void finish_surface(const check::Stage& stage);
    void finish_varyings(const check::Stage& stage, check::SymbolKind which, int32_t kind);
    void finish_volume();
    void finish_grow();
    /// Of attributes alone: the stage is a @Grow.
    bool grows() const { return kind_ == ir::StageKind::kShapeAttributes; }
    void finish_dither(const check::Stage& stage);
    void add_output(std::string name, int32_t kind, int32_t a, int32_t b, ir::ValueId value);
    /// Returns whether a condition holds on every path, by folding or by proof.
    bool always(ir::ValueId condition) const;
    void check_returned(const source::Span& span, const std::string& what, const check::Type& type,
                        const check::Stmt& body);
    void check_assigned(const Variable& v, const check::Symbol& symbol);

    // translate_loop.cpp
    Attempt attempt() const;
    void rollback_code(const Attempt& start);
    void rollback(const Attempt& start);
    /// Returns whether `fact` holds whenever the current point is reached.
    bool is_implied(ir::ValueId fact, ir::ValueId and_where) const;
    ir::ValueId assigned_by_a_trip(ir::ValueId assigned, int32_t which);
    bool unassigned_in_first_trip(ir::ValueId assigned) const;
    bool first_trip_comes_here() const;
    void loop(const check::Stmt& stmt);
    bool fits_unroll_budget(size_t begin, int trips);
    bool unroll(const check::Stmt& stmt);
    bool unroll_in_steps(const check::Stmt& stmt);
    std::set<VariableId> guess_changed(const check::Stmt& stmt) const;
    void run_loop(const check::Stmt& stmt);
    void push_start_test(const check::Stmt& stmt);
    RealLoop make_loop(const check::Stmt& stmt, ir::ValueId guard,
                       const std::set<VariableId>& changed);
    void finish_loop(const check::Stmt& stmt, const RealLoop& made, ir::ValueId guard,
                     bool certain);

    // translate_expr.cpp
    Value expression(const check::Expr& expr);
    ir::ValueId scalar(const check::Expr& expr) { return expression(expr)[0]; }
    Value variable(const check::Expr& expr);
    Value attribute(const check::Expr& expr);
    Value voxel_center();
    Value shape_point();
    Value frame_vector(int32_t first);
    Value convert(const Value& from, const check::Type& from_type, const check::Type& to);
    Value logical(const check::Expr& expr);
    Value conditional(const check::Expr& expr);
    Value assign(const check::Expr& expr);
    Value increment(const check::Expr& expr);
    Value constant_expression(const check::Expr& expr);
    Value constant(const check::Symbol& symbol);
    void add_components(const check::Type& type, std::vector<ir::Type>* out) const;
    std::vector<ir::Type> components(const check::Type& type) const;
    size_t component_count(const check::Type& type) const;
    Value zero(const check::Type& type);
    Value unassigned(const check::Type& type);
    VariableId variable_of(const check::Symbol& symbol) const;

    // translate_target.cpp
    std::pair<size_t, size_t> member_range(const check::Type& type, size_t index) const;
    ir::ValueId index_is(ir::ValueId index, int k, int count);
    void pick_element(const check::Expr& expr, Target* target);
    void make_conditions(Target* target);
    ir::ValueId picked_alternative(const Target& target);
    Target target(const check::Expr& expr);
    void check_read(const Target& of, const source::Span& span);
    void take_as_assigned(const Target& target);
    Value read(const Target& target, const check::Expr& expr);
    void store(Target target, const Value& value);
    std::vector<int32_t> possible_indices(ir::ValueId value, int32_t all) const;

    // translate_matrix.cpp
    Value matrix(const check::Expr& expr);

    // translate_printf.cpp
    Value printf_call(const check::Expr& expr);

    // translate_switch.cpp
    void switch_statement(const check::Stmt& stmt);
    void switch_sections(const std::vector<Section>& sections, size_t at);

    // translate_builtin.cpp
    Value intrinsic(const check::Expr& expr);
    Value sample(const check::Expr& expr);
    Value numbered(const check::Expr& expr, int32_t kind, int32_t count);

    // translate_functions.cpp
    static bool is_function_intrinsic(check::Intrinsic id);
    Value function_call(const check::Expr& expr);
    Value several_results(const check::Expr& expr);
    Value derivatives(const check::Expr& expr, const Value& x);

    // translate_curve.cpp
    Value curve(const check::Expr& expr);

    // translate_gradient.cpp
    Value field(const check::Expr& expr);
    void report_field(const check::Expr& expr, const ir::Instr& fault);

    // translate_query.cpp
    bool asks_in_volume(const check::Expr& expr, const char* name);
    bool asks_of_object(const check::Expr& expr);
    bool refuse_in_dither(const check::Expr& expr, std::string_view what);
    bool refuse_in_shape(const check::Expr& expr, std::string_view what, const char* help);
    Value local_point(const Value& point);
    ir::ValueId query(int32_t object, ir::ValueId guard, const Value& point);
    Value distance(const check::Expr& expr);
    Value nearest_point(const check::Expr& expr);
    Value distance_to(const check::Expr& expr);

    Value composition(const check::Expr& expr);
    Value over(const check::Expr& expr);

    bool too_complex(const source::Span& span);

    const check::Fablet& fablet_;
    ir::StageKind kind_;
    Formulas formulas_{&emit_};
    ir::Stage* stage_;
    diag::Sink* sink_;
    std::vector<ir::ValueId> tests_;       ///< of the open real loops, in this iteration
    std::vector<ir::ValueId> outer_live_;  ///< the condition around each open real loop
    std::map<const check::Symbol*, std::vector<uint32_t>> constants_;  ///< tables, by component
    TranslateOptions options_;
    bool alone_ = false;  ///< an isolated function, whose calls are not inlined
    std::map<const check::Function*, int32_t> callees_;
    std::set<const check::Function*> inlined_;
    int inline_depth_ = 0;
    size_t steps_ = 0;
    size_t step_limit_ = check::kMaxSteps;  ///< lower while a loop is unrolled
    size_t unroll_limit_ = check::kMaxUnrolledSteps;
    std::set<const check::Stmt*> too_long_;  ///< loops that reached it
    int32_t unknowns_ = 0;
    bool gave_up_ = false;
};

}  // namespace openfab::translate
