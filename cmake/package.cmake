# Debian packages: `cpack` in a build of the preset `package` (scripts/package) makes libhybrid0, libhybrid-dev,
# hybrid-apps and python3-hybrid from the components of cmake/install.cmake and python/.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME hybrid)
set(CPACK_PACKAGE_VENDOR "the hybrid mapping authors")
set(CPACK_PACKAGE_CONTACT "The hybrid mapping authors <hybrid@example.org>" CACHE STRING
    "Who maintains the packages, `Name <address>`")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_HOMEPAGE_URL "")
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL libhybrid0 libhybrid-dev hybrid-apps)
if(TARGET hybrid_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
                                                WORLD_READ WORLD_EXECUTE)

set(inference "Discrete and continuous unknowns in one factor graph: where things are,\n\
what they are, and which measurements to believe, estimated together.")

set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_LIBHYBRID0_PACKAGE_NAME libhybrid0)
set(CPACK_DEBIAN_LIBHYBRID0_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBHYBRID0_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBHYBRID0_PACKAGE_CONTROL_EXTRA ${package_dir}/triggers)
set(CPACK_COMPONENT_LIBHYBRID0_DESCRIPTION "discrete-continuous smoothing and mapping, libraries\n${inference}\n\
These are the shared libraries, with the program that parses rawlogs.")

set(CPACK_DEBIAN_LIBHYBRID-DEV_PACKAGE_NAME libhybrid-dev)
set(CPACK_DEBIAN_LIBHYBRID-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBHYBRID-DEV_PACKAGE_DEPENDS
    "libhybrid0 (= ${version}), libeigen3-dev, libmrpt-dev, nlohmann-json3-dev, libfmt-dev")
set(CPACK_COMPONENT_LIBHYBRID-DEV_DESCRIPTION "discrete-continuous smoothing and mapping, headers\n${inference}\n\
These are headers and CMake package for programs and plugins of your own.")

set(CPACK_DEBIAN_HYBRID-APPS_PACKAGE_NAME hybrid-apps)
set(CPACK_DEBIAN_HYBRID-APPS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_HYBRID-APPS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_HYBRID-APPS_PACKAGE_DEPENDS "libhybrid0 (= ${version})")
set(CPACK_DEBIAN_HYBRID-APPS_PACKAGE_RECOMMENDS "mrpt-common")
set(CPACK_COMPONENT_HYBRID-APPS_DESCRIPTION "discrete-continuous smoothing and mapping, programs\n${inference}\n\
These are the programs: MRPT rawlogs to corrected trajectories and maps of\n\
landmarks with classes, pose graphs whose loop closures may be false,\n\
importers of public data sets; with configurations, logs and documents.")

# Its modules work with one version of Python only.
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-hybrid)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "libhybrid0 (= ${version}), python3 (>= ${HYBRID_PYTHON_VERSION}), python3 (<< ${HYBRID_PYTHON_NEXT_VERSION}), \
python3-numpy")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "discrete-continuous smoothing and mapping, Python\n${inference}\n\
This is the Python package: graphs, solvers, selection of loop closures,\n\
association, and the replay of rawlogs.")

# Debian's changelog is about packages, the project's own about their content.
execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%cD OUTPUT_VARIABLE date
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT date)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
file(WRITE ${package_dir}/changelog.Debian "hybrid (${version}) unstable; urgency=medium\n\n\
  * Version ${PROJECT_VERSION}; changelog.gz tells what is new.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
execute_process(COMMAND ${GZIP} -9nf ${package_dir}/changelog.Debian)
file(WRITE ${package_dir}/triggers "activate-noawait ldconfig\n")

# Libraries needed by the programs come from another of these packages.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
include(CPack)
