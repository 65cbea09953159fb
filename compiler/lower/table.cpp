// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "compiler/lower/args.h"
#include "compiler/lower/compile.h"

namespace openfab::lower {

namespace {

std::array<const ir::Stage*, 4> stages_of(const passes::KernelStages& stages) {
    return {&stages.surface, &stages.surface_bounds, &stages.volume, &stages.volume_bounds};
}

std::string function_name(size_t fablet, const ir::Stage& stage, openfab_isa isa) {
    return fmt::format("openfab_f{}_{}_{}", fablet, schedule_name(stage.kind), isa_name(isa));
}

/// A C string literal; bytes that are not plain are octal, which cannot run into what follows.
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
    TableWriter(const std::vector<FabletUnit>& fablets, const std::vector<openfab_isa>& isas)
        : fablets_(fablets), isas_(isas) {}

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

    /// Name of an array of default bits, or 0.
    std::string write_bits(const std::string& name, const std::vector<uint32_t>& bits) {
        if (bits.empty()) return "0";
        line("static const uint32_t {}[] = {{{}}};", name, fmt::join(bits, "u, "));
        return name;
    }

    void write_uniforms(const std::string& prefix, const std::vector<ir::Uniform>& uniforms) {
        std::vector<std::string> bits;
        for (const ir::Uniform& u : uniforms) {
            bits.push_back(
                write_bits(fmt::format("{}_u{}_bits", prefix, bits.size()), u.default_bits));
        }
        line("static const struct openfab_uniform {}_uniforms[] = {{", prefix);
        for (size_t k = 0; k < uniforms.size(); ++k) {
            const ir::Uniform& u = uniforms[k];
            line("    {{{}, {}, {}, {}, {}, {}, {}, {}}},", quoted(u.name), quoted(u.type_name),
                 static_cast<int>(u.kind), static_cast<int>(scalar_type(u.type)), u.components,
                 u.array_length, u.first_index, bits[k]);
        }
        line("    {{0}}}};");
    }

    void write_varyings(const std::string& name, const std::vector<ir::Varying>& varyings) {
        std::vector<std::string> bits;
        for (const ir::Varying& v : varyings) {
            bits.push_back(
                write_bits(fmt::format("{}_{}_bits", name, bits.size()), v.default_bits));
        }
        line("static const struct openfab_varying {}[] = {{", name);
        for (size_t k = 0; k < varyings.size(); ++k) {
            const ir::Varying& v = varyings[k];
            line("    {{{}, {}, {}, {}, {}, {}}},", quoted(v.name), quoted(v.type_name),
                 static_cast<int>(scalar_type(v.type)), v.components, v.source, bits[k]);
        }
        line("    {{0}}}};");
    }

    /// Declarations and argument list of a kernel; its initialiser is returned.
    std::string write_kernel(size_t fablet, const ir::Stage& stage) {
        if (stage.outputs.empty()) return "{{0, 0}, 0, 0}";
        std::array<std::string, OPENFAB_ISA_COUNT> functions = {"0", "0"};
        for (const openfab_isa isa : isas_) {
            const std::string name = function_name(fablet, stage, isa) + "_argv";
            line("int {}(void** args);", name);
            functions[static_cast<size_t>(isa)] = name;
        }
        const std::vector<openfab_arg> args = collect_args(stage).all();
        const std::string name =
            fmt::format("openfab_f{}_{}_args", fablet, schedule_name(stage.kind));
        line("static const struct openfab_arg {}[] = {{", name);
        for (const openfab_arg& arg : args) {
            line("    {{{}, {}, {}, {}}}, /* {} */", static_cast<int>(arg.kind),
                 static_cast<int>(arg.scalar), arg.a, arg.b, arg_name(arg));
        }
        line("}};");
        return fmt::format("{{{{{}, {}}}, {}, {}}}", functions[0], functions[1], args.size(), name);
    }

    void write_fablet(size_t k) {
        const FabletUnit& unit = fablets_[k];
        const ir::Fablet& fablet = *unit.fablet;
        const std::string prefix = fmt::format("openfab_f{}", k);
        write_uniforms(prefix, fablet.uniforms);
        write_varyings(prefix + "_inputs", fablet.surface_inputs);
        write_varyings(prefix + "_outputs", fablet.surface_outputs);
        write_varyings(prefix + "_nearest", fablet.nearest);
        std::vector<std::string> kernels;
        for (const ir::Stage* stage : stages_of(*unit.stages)) {
            kernels.push_back(write_kernel(k, *stage));
        }
        line("static const struct openfab_fablet {} = {{", prefix);
        line("    OPENFAB_ABI_VERSION, {}, {}, {}ull,", quoted(fablet.name),
             quoted(unit.source_name), unit.hash);
        line("    {}, {}_uniforms, {}, {}, {}, {}, {},", fablet.uniforms.size(), prefix,
             fablet.uniform_value_count, fablet.texture_count, fablet.object_count,
             fablet.slot_count, fablet.void_slot);
        line("    {}, {}, {}_inputs, {}, {}_outputs, {}, {}_nearest,", fablet.has_surface ? 1 : 0,
             fablet.surface_inputs.size(), prefix, fablet.surface_outputs.size(), prefix,
             fablet.nearest.size(), prefix);
        line("    {}}};", fmt::join(kernels, ",\n    "));
    }

    const std::vector<FabletUnit>& fablets_;
    const std::vector<openfab_isa>& isas_;
    std::string out_;
};

}  // namespace

std::vector<KernelUnit> list_kernels(const std::vector<FabletUnit>& fablets,
                                     const std::vector<openfab_isa>& isas) {
    std::vector<KernelUnit> out;
    for (size_t k = 0; k < fablets.size(); ++k) {
        for (const ir::Stage* stage : stages_of(*fablets[k].stages)) {
            if (stage->outputs.empty()) continue;
            for (const openfab_isa isa : isas) {
                out.push_back({stage, isa, function_name(k, *stage, isa)});
            }
        }
    }
    std::stable_sort(out.begin(), out.end(), [](const KernelUnit& a, const KernelUnit& b) {
        return a.stage->instrs.size() > b.stage->instrs.size();
    });
    return out;
}

std::string table_source(const std::vector<FabletUnit>& fablets,
                         const std::vector<openfab_isa>& isas) {
    return TableWriter(fablets, isas).run();
}

}  // namespace openfab::lower
