# `cmake --install` installs libraries, headers (under include/hybrid, with the paths of the repository), apps, configs
# and a package file: find_package(hybrid) defines hybrid::hybrid and, if built, hybrid::mrpt.
include(CMakePackageConfigHelpers)

set(HYBRID_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/hybrid)
set(HYBRID_INSTALL_INCLUDEDIR ${CMAKE_INSTALL_INCLUDEDIR}/hybrid)
set(headers libhybrid)
set(targets hybrid)
if(HYBRID_WITH_MRPT)
  list(APPEND headers mrpt_plugins)
  list(APPEND targets hybrid_mrpt)
  set_target_properties(hybrid_mrpt PROPERTIES EXPORT_NAME mrpt)
  get_property(apps DIRECTORY ${PROJECT_SOURCE_DIR}/apps PROPERTY BUILDSYSTEM_TARGETS)
  foreach(app ${apps})
    get_target_property(type ${app} TYPE)
    if(app STREQUAL "hybrid-rawlog-reader")
      install(TARGETS ${app} RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/hybrid COMPONENT libhybrid0)
    elseif(type STREQUAL "EXECUTABLE")
      install(TARGETS ${app} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT hybrid-apps)
      list(APPEND HYBRID_APPS ${app})
    endif()
  endforeach()
  install(DIRECTORY config rawlogs DESTINATION ${CMAKE_INSTALL_DATADIR}/hybrid COMPONENT hybrid-apps
          PATTERN imported EXCLUDE)
endif()

foreach(target ${targets})
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${HYBRID_INSTALL_INCLUDEDIR}>)
endforeach()
install(TARGETS hybrid EXPORT hybridTargets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libhybrid0 NAMELINK_COMPONENT libhybrid-dev)
install(EXPORT hybridTargets NAMESPACE hybrid:: DESTINATION ${HYBRID_INSTALL_CMAKEDIR} COMPONENT libhybrid-dev)
if(HYBRID_WITH_MRPT)
  install(TARGETS hybrid_mrpt EXPORT hybridMrptTargets
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libhybrid0 NAMELINK_COMPONENT libhybrid-dev)
  install(EXPORT hybridMrptTargets NAMESPACE hybrid:: DESTINATION ${HYBRID_INSTALL_CMAKEDIR} COMPONENT libhybrid-dev)
endif()
install(DIRECTORY ${headers} DESTINATION ${HYBRID_INSTALL_INCLUDEDIR} COMPONENT libhybrid-dev
        FILES_MATCHING PATTERN "*.h" PATTERN detail EXCLUDE PATTERN kernels EXCLUDE)
install(DIRECTORY ${PROJECT_BINARY_DIR}/generated/ DESTINATION ${HYBRID_INSTALL_INCLUDEDIR} COMPONENT libhybrid-dev)

configure_package_config_file(cmake/hybridConfig.cmake.in ${PROJECT_BINARY_DIR}/hybridConfig.cmake
                              INSTALL_DESTINATION ${HYBRID_INSTALL_CMAKEDIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/hybridConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/hybridConfig.cmake ${PROJECT_BINARY_DIR}/hybridConfigVersion.cmake
        DESTINATION ${HYBRID_INSTALL_CMAKEDIR} COMPONENT libhybrid-dev)
# For builds without CMake. Paths are relative to the file, so that the installation may move.
file(RELATIVE_PATH HYBRID_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" HYBRID_PC_PREFIX "${HYBRID_PC_PREFIX}")
configure_file(cmake/hybrid.pc.in ${PROJECT_BINARY_DIR}/hybrid.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/hybrid.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libhybrid-dev)
install(FILES LICENSE README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT hybrid-apps)
install(DIRECTORY docs notes examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT hybrid-apps)

if(HYBRID_APPS)
  include(cmake/completions.cmake)
endif()
if(HYBRID_PACKAGES)
  include(cmake/package_files.cmake)
  include(cmake/package.cmake)
endif()
