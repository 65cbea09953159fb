// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <span>

#include "compiler/lower/args.h"
#include "compiler/lower/compile.h"

namespace openfab::lower {

namespace {

std::string function_name(size_t fablet, const KernelPlace& place, openfab_isa isa) {
    return fmt::format("openfab_f{}_{}_{}", fablet, place.name, isa_name(isa));
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
    std::string write_bits(const std::string& name, const uint32_t* bits, int32_t count) {
        if (bits == nullptr) return "0";
        line("static const uint32_t {}[] = {{{}}};", name, fmt::join(bits, bits + count, "u, "));
        return name;
    }

    void write_uniforms(const std::string& prefix, const openfab_fablet& table) {
        const std::span<const openfab_uniform> uniforms(table.uniforms,
                                                        static_cast<size_t>(table.uniform_count));
        std::vector<std::string> bits;
        for (const openfab_uniform& u : uniforms) {
            bits.push_back(write_bits(fmt::format("{}_u{}_bits", prefix, bits.size()),
                                      u.default_bits, u.components * u.array_length));
        }
        line("static const struct openfab_uniform {}_uniforms[] = {{", prefix);
        for (size_t k = 0; k < uniforms.size(); ++k) {
            const openfab_uniform& u = uniforms[k];
            line("    {{{}, {}, {}, {}, {}, {}, {}, {}}},", quoted(u.name), quoted(u.type_name),
                 static_cast<int>(u.kind), static_cast<int>(u.scalar), u.components, u.array_length,
                 u.first_index, bits[k]);
        }
        line("    {{0}}}};");
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

    /// Declarations and argument list of a kernel; its initialiser is returned.
    std::string write_kernel(size_t fablet, const KernelPlace& place,
                             const openfab_kernel& kernel) {
        std::array<std::string, OPENFAB_ISA_COUNT> functions = {"0", "0"};
        for (const openfab_isa isa : isas_) {
            const std::string name = function_name(fablet, place, isa) + "_argv";
            line("int {}(void** args);", name);
            functions[static_cast<size_t>(isa)] = name;
        }
        const std::string name = fmt::format("openfab_f{}_{}_args", fablet, place.name);
        line("static const struct openfab_arg {}[] = {{", name);
        for (int32_t k = 0; k < kernel.arg_count; ++k) {
            const openfab_arg& arg = kernel.args[k];
            line("    {{{}, {}, {}, {}}}, /* {} */", static_cast<int>(arg.kind),
                 static_cast<int>(arg.scalar), arg.a, arg.b, arg_name(arg));
        }
        line("}};");
        return fmt::format("{{{{{}, {}}}, {}, {}}}", functions[0], functions[1], kernel.arg_count,
                           name);
    }

    void write_fablet(size_t k) {
        const FabletData data(fablets_[k]);
        const openfab_fablet& table = data.table();
        const std::string prefix = fmt::format("openfab_f{}", k);
        write_uniforms(prefix, table);
        write_varyings(prefix + "_inputs", table.surface_inputs, table.surface_input_count);
        write_varyings(prefix + "_outputs", table.surface_outputs, table.surface_output_count);
        write_varyings(prefix + "_nearest", table.nearest, table.nearest_count);
        std::array<std::string, 4> kernels;
        kernels.fill("{{0, 0}, 0, 0}");
        for (const KernelPlace& place : kernel_places(*fablets_[k].stages)) {
            const auto slot = static_cast<size_t>(place.stage->kind);
            kernels[slot] = write_kernel(k, place, table.*place.kernel);
        }
        line("static const struct openfab_fablet {} = {{", prefix);
        line("    OPENFAB_ABI_VERSION, {}, {}, {}ull,", quoted(table.name),
             quoted(table.source_name), table.hash);
        line("    {}, {}_uniforms, {}, {}, {}, {}, {},", table.uniform_count, prefix,
             table.uniform_value_count, table.texture_count, table.object_count, table.slot_count,
             table.void_slot);
        line("    {}, {}, {}_inputs, {}, {}_outputs, {}, {}_nearest,", table.has_surface,
             table.surface_input_count, prefix, table.surface_output_count, prefix,
             table.nearest_count, prefix);
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
        for (const KernelPlace& place : kernel_places(*fablets[k].stages)) {
            for (const openfab_isa isa : isas) {
                out.push_back({k, place, isa, function_name(k, place, isa)});
            }
        }
    }
    std::stable_sort(out.begin(), out.end(), [](const KernelUnit& a, const KernelUnit& b) {
        return a.place.stage->instrs.size() > b.place.stage->instrs.size();
    });
    return out;
}

std::string table_source(const std::vector<FabletUnit>& fablets,
                         const std::vector<openfab_isa>& isas) {
    return TableWriter(fablets, isas).run();
}

}  // namespace openfab::lower
