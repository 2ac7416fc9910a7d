# See CMakeLists.txt. Fails with the output of the step that failed.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    string(JOIN " " command ${ARGV})
    message(FATAL_ERROR "${command}\n${output}")
  endif()
endfunction()

set(prefix ${WORK_DIR}/prefix)
set(build ${WORK_DIR}/build)
file(REMOVE_RECURSE ${prefix})
run(${CMAKE_COMMAND} --install ${HYBRID_BINARY_DIR} --prefix ${prefix})

# Shells find the completion of the programs that were built.
foreach(place bash-completion/completions/hybrid-replay zsh/site-functions/_hybrid-replay)
  if(EXISTS ${HYBRID_BINARY_DIR}/completions/bash/hybrid-replay AND NOT EXISTS ${prefix}/share/${place})
    message(FATAL_ERROR "no ${place} under ${prefix}/share")
  endif()
endforeach()

# What is installed speaks neither of the tree it came from nor of the processor of this machine.
file(GLOB_RECURSE packages ${prefix}/*.cmake)
if(NOT packages)
  message(FATAL_ERROR "no package files under ${prefix}")
endif()
foreach(package ${packages})
  file(READ ${package} text)
  foreach(word ${HYBRID_SOURCE_DIR} TBB cholmod -march -mavx -ffp -U__)
    string(FIND "${text}" "${word}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${package} mentions ${word}")
    endif()
  endforeach()
endforeach()

# What the libraries show, and that neither holds a copy of the other.
run(${Python3_EXECUTABLE} -B ${SOURCE_DIR}/../exports.py ${prefix}/lib)

# Headers that have not changed since are not compiled again.
set(launcher "")
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(launcher -DCMAKE_CXX_COMPILER_LAUNCHER=${CCACHE_PROGRAM})
endif()

# A program that is built without CMake, by pkg-config.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} ${prefix}/lib/pkgconfig)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs hybrid OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE)
  separate_arguments(flags)
  if(SANITIZE)
    list(APPEND flags -fsanitize=${SANITIZE})
  endif()
  run(${CXX} -std=c++17 ${HYBRID_SOURCE_DIR}/examples/first_graph.cpp -o ${WORK_DIR}/first_graph ${flags}
      -Wl,-rpath,${prefix}/lib)
  run(${WORK_DIR}/first_graph)
endif()

# The Python package finds the installed libraries by itself.
if(PYTHON)
  set(first ${HYBRID_SOURCE_DIR}/python/examples/first_graph.py)
  run(${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/${PYTHON_DIR} ${PYTHON} -B ${first})
  if(WITH_MRPT)
    run(${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/${PYTHON_DIR} ${PYTHON} -B -c "import hybrid._mrpt")
  endif()
endif()

# A user may or may not compile for the processor of the machine, or with the address sanitizer; Eigen objects cross
# the border in all cases.
set(ways "-O1" "-march=native")
if(NOT SANITIZE)
  list(APPEND ways "-fsanitize=address -O1")
  set(ENV{ASAN_OPTIONS} detect_leaks=0)  # what MRPT keeps to its end is not ours
endif()
foreach(flags ${ways})
  file(REMOVE_RECURSE ${build})
  if(SANITIZE)
    string(APPEND flags " -fsanitize=${SANITIZE}")
  endif()
  run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR} -B ${build} -DCMAKE_PREFIX_PATH=${prefix} -DWITH_MRPT=${WITH_MRPT}
      -DEXAMPLES=${HYBRID_SOURCE_DIR}/examples
      -DCMAKE_CXX_COMPILER=${CXX} ${launcher} -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_CXX_FLAGS=${flags})
  run(${CMAKE_COMMAND} --build ${build} --parallel 2)
  run(${build}/example)
  run(${build}/border)
  if(WITH_MRPT)
    run(${build}/example_mrpt)
  endif()
endforeach()

# The plugin that docs/writing_a_plugin.md tells to copy.
if(WITH_MRPT)
  file(REMOVE_RECURSE ${build})
  run(${CMAKE_COMMAND} -G Ninja -S ${HYBRID_SOURCE_DIR}/examples/plugin -B ${build} -DCMAKE_PREFIX_PATH=${prefix}
      -DCMAKE_CXX_COMPILER=${CXX} ${launcher})
  run(${CMAKE_COMMAND} --build ${build} --parallel 2)
endif()

# Without the flags of the target, a program in which Eigen would allocate otherwise does not compile, whatever it
# includes.
file(WRITE ${WORK_DIR}/graph.cpp "#include \"libhybrid/hybrid/graph.h\"\nint main() {}\n")
foreach(flag -mavx2 -fsanitize=address)
  execute_process(COMMAND ${CXX} -std=c++17 -Wfatal-errors ${flag} -I${prefix}/include/hybrid -isystem ${EIGEN} -fsyntax-only
                          ${WORK_DIR}/graph.cpp RESULT_VARIABLE code ERROR_VARIABLE output)
  string(FIND "${output}" "use hybrid::hybrid of CMake" at)
  if(code EQUAL 0 OR at EQUAL -1)
    message(FATAL_ERROR "compiling with ${flag} should explain itself, but gave ${code}:\n${output}")
  endif()
endforeach()
run(${CXX} -std=c++17 -I${prefix}/include/hybrid -isystem ${EIGEN} -fsyntax-only ${WORK_DIR}/graph.cpp)
