# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
# cmake -DMODULES=folder -DOUTPUT=header -P embed_modules.cmake: the standard library as a C++ header.
file(GLOB files ${MODULES}/*.fl)
list(SORT files)
set(text "// Generated from stdlib/*.fl by embed_modules.cmake.\n#pragma once\n\nnamespace openfab::driver {\n\n")
string(APPEND text "struct EmbeddedModule {\n    const char* name;\n    const char* text;\n};\n\n")
string(APPEND text "inline constexpr EmbeddedModule kEmbeddedModules[] = {\n")
foreach(file IN LISTS files)
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} content)
    string(APPEND text "    {\"${name}\", R\"openfl(${content})openfl\"},\n")
endforeach()
# An array cannot be empty.
string(APPEND text "    {nullptr, nullptr},\n};\n\n}  // namespace openfab::driver\n")
file(WRITE ${OUTPUT} "${text}")
