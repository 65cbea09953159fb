// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The commands of `openfab`. main.cpp defines their command lines and reports their errors.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "program/output_options.h"
#include "tools/openfab/import.h"
#include "tools/viewer/view.h"

namespace openfab::tools {

struct ImportArguments {
    std::string file, folder, unit, up, size, picture_size, repair, memory, tolerance;
    std::string mesh;  ///< of looks of MaterialX
    bool recentre = false, list = false, json = false, quiet = false;
    ImportOptions import;
};

struct ExportOptions {
    std::string file;
    std::string memory;
    program::OutputOptions print;  ///< output, format, previews, png_indexed, flip_x
    std::vector<std::string> previews;
    std::string png = "rgba";
    int32_t slice = -1;
    std::string voxel;                  ///< of stacks of images of a world
    bool composite = false;             ///< a world's mixtures as the volumetric extension has them
    bool programs = false;              ///< a world's programs may run
    std::vector<std::string> settings;  ///< of a world, as of `openfab print`
};

struct CouponArguments {
    std::string printer, folder, format;
    std::vector<std::string> materials;  ///< empty: those of the profile
    std::vector<std::string> print;      ///< options of a print, on the size of its voxels
};

struct MergeOptions {
    std::vector<std::string> files;
    bool whole = false;    ///< fails where slices of the print are in no file
    ExportOptions output;  ///< without a file and a slice
};

struct ViewArguments {
    viewer::ViewOptions view;
    std::string new_folder, from = "starter";  ///< of --new
    std::string memory;
};

struct ReceiveArguments {
    std::string listen, output, token_file, tls_certificate, tls_key, layer_time, memory, log;
    int32_t buffer = 20;
};

struct ArchiveArguments {
    std::string file, output, memory, person;
    std::vector<std::string> attached;
    bool reprint = false, programs = false;
    int32_t threads = 0;  ///< of the reprint; 0: as many as prints take
};

struct CacheArguments {
    std::string limit, purge;
    bool files = false;  ///< lists each
};

/// `new`: makes a folder, whose last part names the fablet, from a template.
Result<std::string> make_folder(const std::string& path, const std::string& from);
/// Returns "starter, solid, …", and each of them.
std::string template_names();
std::vector<std::string> template_list();
/// `import`: makes a world of a mesh, or lists what it holds.
Result<void> run_import(ImportArguments arguments);
/// Makes a world of a mesh; returns its file.
Result<std::filesystem::path> import_mesh(ImportArguments arguments);
/// `info` of an .ofr file, a folder of slices, a world, a mesh, a picture or a volume; `memory`: see memory_of. `json`: of a
/// mesh.
Result<void> info(const std::string& file, const std::vector<std::string>& allow,
                  const std::string& memory, bool json);
/// `verify`: checks every slice of an .ofr file or a folder, an array, a mesh or a package of a print.
Result<void> verify(const std::string& file, const std::string& memory);
/// `export`: writes an .ofr file as something else.
Result<void> run_export(ExportOptions options);
/// `merge`: writes the parts of one print, .ofr files made with `--slices`, as one.
Result<void> run_merge(MergeOptions options);
/// `archive`: keeps all that a print was made from in a package, or makes it again from one.
Result<void> run_archive(const ArchiveArguments& arguments);
/// Returns the hash of a complete print, a file or a folder, as it says itself.
Result<std::string> hash_of_print(const std::string& output);
/// `cache`: lists what is kept between prints, or removes of it.
Result<void> run_cache(const CacheArguments& arguments);
/// Returns what it can purge.
std::vector<std::string> cache_kinds();
/// `printers`: lists the printers that are known, or shows one, by name or file.
Result<void> list_printers(const std::string& name, bool json);
struct PropertyArguments {
    std::string table, output, temperature, rate;
};
/// `property`: writes a table of mixtures as a module of OpenFL, to standard output where `output` is
/// empty.
Result<void> make_property_module(const PropertyArguments& arguments);
/// `coupon`: writes the coupon's world for a printer, and prints it; returns only on an error.
Result<void> run_coupon(const CouponArguments& arguments);
/// `receive`: takes one print that is streamed.
Result<void> run_receive(const ReceiveArguments& arguments);

/// `view`: serves a page that shows prints, or a world; returns only on an error.
Result<void> run_view(ViewArguments arguments);

/// Runs `openfab print …`: compiles what changed and replaces the process by the print binary;
/// returns the exit code where that fails. It parses the print binary's own options, so it is not a
/// CLI11 command.
int print_command(int argc, char** argv);
/// The same, of the words after `print`.
Result<void> run_print(std::vector<std::string> arguments);

/// Replaces this process by a program beside it, as `openfab-texture`; returns an exit code where that
/// fails.
int start_helper(const char* name, char** argv);

}  // namespace openfab::tools
