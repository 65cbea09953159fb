// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of other shading languages and their equivalents in OpenFL. Functions return the text of a
// help line, empty for unknown words.

#include <string>
#include <string_view>

#include "compiler/check/type.h"

namespace openfab::check {

/// Returns the OpenFL name of a type or function that only differs in name, else empty.
std::string renamed_type(std::string_view name);
std::string renamed_function(std::string_view name);

std::string foreign_type_help(std::string_view name);
std::string foreign_function_help(std::string_view name);
std::string foreign_attribute_help(std::string_view name, const Type& attributes);
std::string foreign_name_help(std::string_view name);

/// True for `auto` and the like, which leave a variable's type to its value.
bool infers_type(std::string_view name);

/// A function of the standard library.
struct LibraryName {
    std::string_view name;        ///< empty if there is none
    std::string_view form;        ///< with its arguments
    bool same_arguments = false;  ///< the other name takes the same ones
};

/// Returns the library's function that others know by this name.
LibraryName library_name(std::string_view name);
/// Returns the declaration of a constant such as `PI`; empty for other names.
std::string constant_of(std::string_view name);
/// True for functions that read a picture or volume in other languages.
bool is_foreign_lookup(std::string_view name);

}  // namespace openfab::check
