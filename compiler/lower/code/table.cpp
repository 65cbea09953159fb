// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/table.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <span>

#include "compiler/lower/algorithm/args.h"

namespace openfab::lower {

namespace {

constexpr const char* kNoKernel = "{{0}, 0, 0}";

/// Returns a C string literal; other bytes are octal, which cannot merge with the next character.
std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < ' ' || byte > '~' || c == '"' || c == '\\' || c == '?') {
            out += fmt::format("\\{:03o}", byte);
        } else {
            out += c;
        }
    }
    return out + '"';
}

class TableWriter {
  public:
    TableWriter(const std::vector<FabletUnit>& fablets, const std::vector<KernelUnit>& kernels,
                const std::vector<int64_t>& stored_bytes)
        : fablets_(fablets), kernels_(kernels), stored_bytes_(stored_bytes) {}

    std::string run() {
        for (size_t k = 0; k < fablets_.size(); ++k)
            write_fablet(k);
        line("static const struct openfab_fablet* const openfab_all[] = {{");
        for (size_t k = 0; k < fablets_.size(); ++k)
            line("    &openfab_f{},", k);
        line("    0}};");
        line("const struct openfab_fablet_list openfab_fablets = {{{}, openfab_all}};",
             fablets_.size());
        return std::move(out_);
    }

  private:
    template <typename... Args>
    void line(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
        out_ += '\n';
    }

    /// Returns the name of an array of default bits, or 0.
    std::string write_bits(const std::string& name, const uint32_t* bits, int32_t count) {
        if (bits == nullptr) return "0";
        line("static const uint32_t {}[] = {{{}}};", name, fmt::join(bits, bits + count, "u, "));
        return name;
    }

    /// Returns the name of the two limits, or 0.
    std::string write_limits(const std::string& name, const double* limits) {
        if (limits == nullptr) return "0";
        line("static const double {}[] = {{{}, {}}};", name, limits[0], limits[1]);
        return name;
    }

    void write_uniforms(const std::string& prefix, const openfab_fablet& table) {
        const std::span<const openfab_uniform> uniforms(table.uniforms,
                                                        static_cast<size_t>(table.uniform_count));
        std::vector<std::string> bits, limits;
        for (const openfab_uniform& u : uniforms) {
            limits.push_back(
                write_limits(fmt::format("{}_u{}_limits", prefix, limits.size()), u.limits));
            bits.push_back(write_bits(fmt::format("{}_u{}_bits", prefix, bits.size()),
                                      u.default_bits, u.components * u.array_length));
        }
        line("static const struct openfab_uniform {}_uniforms[] = {{", prefix);
        for (size_t k = 0; k < uniforms.size(); ++k) {
            const openfab_uniform& u = uniforms[k];
            line("    {{{}, {}, {}, {}, {}, {}, {}, {}, {}}},", quoted(u.name), quoted(u.type_name),
                 static_cast<int>(u.kind), static_cast<int>(u.scalar), u.components, u.array_length,
                 u.first_index, bits[k], limits[k]);
        }
        line("    {{0}}}};");
    }

    /// Returns the name of the list, or 0.
    std::string write_table_values(const std::string& name, const openfab_fablet& table) {
        if (table.table_value_count == 0) return "0";
        line("static const struct openfab_table_value {}[] = {{", name);
        for (const openfab_table_value& v : listed(table.table_values, table.table_value_count))
            line("    {{{}, {}u}},", v.from, v.bits);
        line("}};");
        return name;
    }

    void write_varyings(const std::string& name, const openfab_varying* first, int32_t count) {
        const std::span<const openfab_varying> varyings(first, static_cast<size_t>(count));
        std::vector<std::string> bits;
        for (const openfab_varying& v : varyings) {
            bits.push_back(write_bits(fmt::format("{}_{}_bits", name, bits.size()), v.default_bits,
                                      v.components));
        }
        line("static const struct openfab_varying {}[] = {{", name);
        for (size_t k = 0; k < varyings.size(); ++k) {
            const openfab_varying& v = varyings[k];
            line("    {{{}, {}, {}, {}, {}, {}}},", quoted(v.name), quoted(v.type_name),
                 static_cast<int>(v.scalar), v.components, v.source, bits[k]);
        }
        line("    {{0}}}};");
    }

    /// Writes the declarations and argument list of a kernel; returns its initializer.
    std::string write_kernel(size_t fablet, const KernelSlot& slot, const openfab_kernel& kernel) {
        std::array<std::string, OPENFAB_ISA_COUNT> functions = {"0", "0", "0"};
        for (const KernelUnit& unit : kernels_) {
            if (unit.fablet != fablet || unit.slot.name != slot.name) continue;
            std::string& name = functions[unit.request.isa];
            name = unit.request.function + "_argv";
            line("int {}(void** args);", name);
        }
        const std::string args = fmt::format("openfab_f{}_{}_args", fablet, slot.name);
        return write_args(args, functions, kernel);
    }

    std::string write_args(const std::string& name,
                           const std::array<std::string, OPENFAB_ISA_COUNT>& functions,
                           const openfab_kernel& kernel) {
        if (kernel.arg_count == 0) return kNoKernel;
        const std::string args = write_list(name, listed(kernel.args, kernel.arg_count));
        return fmt::format("{{{{{}}}, {}, {}, {}}}", fmt::join(functions, ", "), kernel.arg_count,
                           args, kernel.packed);
    }

    /// Name of a list of arguments, or 0.
    std::string write_list(const std::string& name, std::span<const openfab_arg> args) {
        if (args.empty()) return "0";
        line("static const struct openfab_arg {}[] = {{", name);
        for (const openfab_arg& arg : args) {
            line("    {{{}, {}, {}, {}}}, /* {} */", static_cast<int>(arg.kind),
                 static_cast<int>(arg.scalar), arg.a, arg.b, arg_name(arg));
        }
        line("}};");
        return name;
    }

    /// Writes the lists of a segmented stage; returns the initializer of its openfab_segments.
    std::string write_segments(const std::string& prefix, const std::vector<std::string>& kernels,
                               const openfab_segments& segments) {
        if (segments.step_count == 0) return "{0}";
        line("static const struct openfab_step {}_steps[] = {{", prefix);
        for (const openfab_step& s : listed(segments.steps, segments.step_count))
            line("    {{{}, {}, {}}},", static_cast<int>(s.kind), s.a, s.b);
        line("}};");
        line("static const struct openfab_kernel {}_kernels[] = {{{}}};", prefix,
             fmt::join(kernels, ", "));
        const auto queries = listed(segments.queries, segments.query_count);
        for (size_t k = 0; k < queries.size(); ++k) {
            line("static const struct openfab_query_output {}_q{}[] = {{", prefix, k);
            for (const openfab_query_output& o :
                 listed(queries[k].outputs, queries[k].output_count)) {
                line("    {{{}, {}, {}, {}}},", static_cast<int>(o.kind), o.a, o.b, o.state);
            }
            line("    {{0}}}};");
        }
        line("static const struct openfab_query {}_queries[] = {{", prefix);
        for (size_t k = 0; k < queries.size(); ++k) {
            const openfab_query& q = queries[k];
            line("    {{{}, {}, {{{}, {}, {}}}, {}, {}, {}, {}_q{}}},", q.object, q.guard,
                 q.point[0], q.point[1], q.point[2], q.stop, q.seed, q.output_count, prefix, k);
        }
        line("    {{0}}}};");
        const auto printfs = listed(segments.printfs, segments.printf_count);
        for (size_t k = 0; k < printfs.size(); ++k) {
            line("static const int32_t {}_p{}[] = {{{}{}0}};", prefix, k,
                 fmt::join(listed(printfs[k].values, printfs[k].value_count), ", "),
                 printfs[k].value_count > 0 ? ", " : "");
        }
        line("static const struct openfab_printf {}_printfs[] = {{", prefix);
        for (size_t k = 0; k < printfs.size(); ++k) {
            const openfab_printf& p = printfs[k];
            line("    {{{}, {}, {}, {}, {}, {}, {}, {}_p{}}},", quoted(p.format), p.is_assert,
                 quoted(p.source), p.line, p.column, p.guard, p.value_count, prefix, k);
        }
        line("    {{0}}}};");
        std::vector<int> states;
        for (const openfab_scalar_type type : listed(segments.states, segments.state_count))
            states.push_back(static_cast<int>(type));
        line("static const enum openfab_scalar_type {}_states[] = {{{}}};", prefix,
             fmt::join(states, ", "));
        line("static const struct openfab_elements {}_elements[] = {{", prefix);
        for (const openfab_elements& e : listed(segments.elements, segments.elements_count)) {
            line("    {{{}, {}, {}, {}, {}, {}, {}, {}}},", static_cast<int>(e.kind), e.first,
                 e.apart, e.count, e.index, e.value, e.value_apart, e.guard);
        }
        line("    {{0}}}};");
        return fmt::format(
            "{{{1}, {0}_steps, {2}, {0}_kernels, {3}, {0}_queries, {4}, {0}_printfs, {5}, "
            "{0}_states, {6}, {0}_elements}}",
            prefix, segments.step_count, segments.kernel_count, segments.query_count,
            segments.printf_count, segments.state_count, segments.elements_count);
    }

    template <typename T>
    static std::span<const T> listed(const T* first, int32_t count) {
        return {first, static_cast<size_t>(count)};
    }

    void write_fablet(size_t k) {
        const FabletData data(fablets_[k]);
        const openfab_fablet& table = data.table();
        const std::string prefix = fmt::format("openfab_f{}", k);
        write_uniforms(prefix, table);
        write_varyings(prefix + "_inputs", table.surface_inputs, table.surface_input_count);
        write_varyings(prefix + "_outputs", table.surface_outputs, table.surface_output_count);
        write_varyings(prefix + "_nearest", table.nearest, table.nearest_count);
        std::array<std::string, 6> kernels;
        kernels.fill(kNoKernel);
        std::array<std::vector<std::string>, 2> segment_kernels;
        ShapeTexts shape;
        for (const KernelSlot& slot : kernel_slots(*fablets_[k].stages)) {
            const std::string text = write_kernel(k, slot, data.kernel(slot));
            if (shape.take(slot, text)) continue;
            switch (slot.stage->kind) {
                case ir::StageKind::kSurfaceSegment:
                    segment_kernels[0].push_back(text);
                    break;
                case ir::StageKind::kVolumeSegment:
                    segment_kernels[1].push_back(text);
                    break;
                case ir::StageKind::kDerived:
                    kernels[4] = text;
                    break;
                case ir::StageKind::kVolumeDemand:
                    kernels[5] = text;
                    break;
                case ir::StageKind::kSurface:
                case ir::StageKind::kSurfaceBounds:
                case ir::StageKind::kVolume:
                case ir::StageKind::kVolumeBounds:
                    kernels[static_cast<size_t>(slot.stage->kind)] = text;
                    break;
                case ir::StageKind::kDither:
                case ir::StageKind::kShape:
                case ir::StageKind::kShapeAttributes:
                case ir::StageKind::kShapeBounds:
                case ir::StageKind::kShapeSegment:
                    break;  // ShapeTexts has those of shapes; a rule is a table of its own
            }
        }
        if (table.surface_segments.step_count > 0) {
            kernels[0] = write_args(prefix + "_surface_args", {"0", "0", "0"}, table.surface);
        }
        const std::string values = write_table_values(prefix + "_values", table);
        const std::string fields =
            write_list(prefix + "_fields", listed(table.fields, table.field_count));
        const std::string surface_segments =
            write_segments(prefix + "_surface", segment_kernels[0], table.surface_segments);
        const std::string volume_segments =
            write_segments(prefix + "_volume", segment_kernels[1], table.volume_segments);
        const std::string shaped = write_shape(prefix + "_shape", table.shape, shape);
        line("static const struct openfab_fablet {} = {{", prefix);
        line("    OPENFAB_ABI_VERSION, {}, {}, {}ull,", quoted(table.name),
             quoted(table.source_name), table.hash);
        line("    {}, {}_uniforms, {}, {}, {}, {}, {},", table.uniform_count, prefix,
             table.uniform_value_count, table.texture_count, table.object_count, table.slot_count,
             table.void_slot);
        line("    {}, {}, {}, {}_inputs, {}, {}_outputs, {}, {}_nearest,", table.has_dither,
             table.has_surface, table.surface_input_count, prefix, table.surface_output_count,
             prefix, table.nearest_count, prefix);
        line("    {},", fmt::join(kernels.begin(), kernels.begin() + 4, ",\n    "));
        line("    {}, {},", surface_segments, volume_segments);
        line("    {}, {},", table.derived_count, kernels[4]);
        line("    {}, {},", table.table_value_count, values);
        line("    {}, {},", table.field_count, fields);
        line("    {}, {}, {}}};", kernels[5], stored_bytes_[k], shaped);
    }

    /// The initializers of a shape's kernels.
    struct ShapeTexts {
        std::string values = kNoKernel, attributes = kNoKernel, bounds = kNoKernel;
        std::vector<std::string> value_segments, attribute_segments;

        bool take(const KernelSlot& slot, const std::string& text) {
            if (slot.shape_segments == &openfab_shape::value_segments) {
                value_segments.push_back(text);
            } else if (slot.shape_segments == &openfab_shape::attribute_segments) {
                attribute_segments.push_back(text);
            } else if (slot.shape_kernel == &openfab_shape::values) {
                values = text;
            } else if (slot.shape_kernel == &openfab_shape::attributes) {
                attributes = text;
            } else if (slot.shape_kernel == &openfab_shape::bounds) {
                bounds = text;
            } else {
                return false;
            }
            return true;
        }
    };

    /// Returns what points to the shape, or 0.
    std::string write_shape(const std::string& name, const openfab_shape* shape,
                            ShapeTexts& texts) {
        if (shape == nullptr) return "0";
        write_varyings(name + "_outputs", shape->outputs, shape->output_count);
        if (shape->value_segments.step_count > 0)
            texts.values = write_args(name + "_args", {"0", "0", "0"}, shape->values);
        if (shape->attribute_segments.step_count > 0)
            texts.attributes =
                write_args(name + "_attribute_args", {"0", "0", "0"}, shape->attributes);
        const std::string value_segments =
            write_segments(name + "_value", texts.value_segments, shape->value_segments);
        const std::string attribute_segments = write_segments(
            name + "_attribute", texts.attribute_segments, shape->attribute_segments);
        line("static const struct openfab_shape {} = {{", name);
        line("    {}, {}, {}_outputs,", shape->is_distance, shape->output_count, name);
        line("    {},\n    {},\n    {},", texts.values, texts.attributes, texts.bounds);
        line("    {}, {}}};", value_segments, attribute_segments);
        return "&" + name;
    }

    const std::vector<FabletUnit>& fablets_;
    const std::vector<KernelUnit>& kernels_;
    const std::vector<int64_t>& stored_bytes_;
    std::string out_;
};

}  // namespace

std::string table_source(const std::vector<FabletUnit>& fablets,
                         const std::vector<KernelUnit>& kernels,
                         const std::vector<int64_t>& stored_bytes) {
    return TableWriter(fablets, kernels, stored_bytes).run();
}

}  // namespace openfab::lower
