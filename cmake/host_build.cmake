# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# Sanitizers do not see into code that LLVM generates, and make LLVM several times slower. A build with
# OPENFAB_HOST_BUILD takes code generators and generated code from that folder, another build of the same sources: the
# stages' kernels, and the compiler that makes the tests' print programs. All else is built here, including the runtime
# that those programs are linked with.
set(OPENFAB_HOST_BUILD "" CACHE PATH "A build without sanitizers whose compiler and kernels are taken; empty: this one's own")
if(OPENFAB_HOST_BUILD AND NOT EXISTS ${OPENFAB_HOST_BUILD}/bin/openflc)
    message(FATAL_ERROR "${OPENFAB_HOST_BUILD}/bin/openflc is not there; build it first: "
        "cmake --preset release && cmake --build --preset release")
endif()

# openfab_host_file(FILE FROM): FILE of this build is a copy of FROM in the other one.
function(openfab_host_file file from)
    add_custom_command(OUTPUT ${file} COMMAND ${CMAKE_COMMAND} -E copy ${OPENFAB_HOST_BUILD}/${from} ${file}
        DEPENDS ${OPENFAB_HOST_BUILD}/${from} COMMENT "Taking ${from} from ${OPENFAB_HOST_BUILD}" VERBATIM)
endfunction()
