# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
# Print binaries run on machines that have nothing installed, so compressors, parsers and hashes are linked statically
# where the system has an archive. The Python extension is a shared library itself, and a system's archives need not be
# position independent (libexpat.a of Debian 13 is not): it gets the shared ones.
function(openfab_static_library target header archive shared)
    # A name of its own, since a build folder of before remembers the archive.
    set(file ${target}_FILE)
    if(OPENFAB_PYTHON)
        set(archive)
        set(file ${target}_SHARED_FILE)
    endif()
    find_library(${file} NAMES ${archive} ${shared})
    find_path(${target}_INCLUDE ${header})
    if(NOT ${file} OR NOT ${target}_INCLUDE)
        message(FATAL_ERROR "${shared} was not found: run scripts/setup")
    endif()
    add_library(${target} INTERFACE)
    target_include_directories(${target} SYSTEM INTERFACE ${${target}_INCLUDE})
    target_link_libraries(${target} INTERFACE ${${file}})
endfunction()
openfab_static_library(openfab_deflate libdeflate.h libdeflate.a deflate)
openfab_static_library(openfab_expat expat.h libexpat.a expat)
openfab_static_library(openfab_isal isa-l/igzip_lib.h libisal.a isal)
openfab_static_library(openfab_zlib zlib.h libz.a z)
openfab_static_library(openfab_zstd zstd.h libzstd.a zstd)
