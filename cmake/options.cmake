# Compiler settings. Every target of ours calls hybrid_configure(target).

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)

include(GNUInstallDirs)
set(CMAKE_INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR} $ORIGIN)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# For libraries: only symbols marked by libhybrid/export.h are exported. Clang takes the mark of a namespace for that block
# of it alone, not for what is declared there and defined elsewhere: with it, everything is exported.
function(hybrid_hide target)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    set_target_properties(${target} PROPERTIES CXX_VISIBILITY_PRESET hidden)
  endif()
endfunction()

# For shared libraries: before version 1, each minor version has an ABI of its own. Undefined symbols are errors when
# the library is linked, not only when a program is.
function(hybrid_number target)
  if(NOT HYBRID_SANITIZE AND NOT HYBRID_FUZZ)
    target_link_options(${target} PRIVATE -Wl,--no-undefined)
  endif()
  set_target_properties(${target} PROPERTIES VERSION ${PROJECT_VERSION}
                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
endfunction()

function(hybrid_configure target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic $<$<BOOL:${HYBRID_WERROR}>:-Werror>)
  # A fused multiply-add rounds differently from a multiplication and an addition: without it, results are the same on
  # every processor.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # False positives of gcc 12 in dead branches of Eigen's vectorised code.
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-maybe-uninitialized -Wno-stringop-overread)
    if(CMAKE_UNITY_BUILD)  # gcc warns of private classes in the included sources of a unity build
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
  if(HYBRID_FUZZ)
    set(fuzz address,undefined,float-cast-overflow)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link,${fuzz} -fno-omit-frame-pointer
                                             -fno-sanitize-recover=all)
    target_link_options(${target} PRIVATE -fsanitize=${fuzz})
  endif()
  if(HYBRID_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${HYBRID_SANITIZE} -fno-omit-frame-pointer
                                             -fno-sanitize-recover=all)
    target_link_options(${target} PRIVATE -fsanitize=${HYBRID_SANITIZE})
    if(HYBRID_SANITIZE MATCHES undefined)
      # vptr probes addresses through a pipe, which the process that parses rawlogs may not open. A null pointer ends a
      # program anyway, and alignment and object-size check each access of Eigen: with them a build takes twice the time.
      target_compile_options(${target} PRIVATE -fno-sanitize=vptr,null,alignment,object-size)
    endif()
  endif()
endfunction()
