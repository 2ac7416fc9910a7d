# `cmake --install` puts libraries, headers (under include/hybrid, with the repository's own paths), apps, configs
# and a package file, so that find_package(hybrid) gives hybrid::hybrid and, if built, hybrid::mrpt.
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
      install(TARGETS ${app} RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/hybrid)
    elseif(type STREQUAL "EXECUTABLE")
      install(TARGETS ${app} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
    endif()
  endforeach()
  if(EXISTS ${PROJECT_SOURCE_DIR}/config)
    install(DIRECTORY config DESTINATION ${CMAKE_INSTALL_DATADIR}/hybrid)
  endif()
endif()

foreach(target ${targets})
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${HYBRID_INSTALL_INCLUDEDIR}>)
endforeach()
install(TARGETS ${targets} EXPORT hybridTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${headers} DESTINATION ${HYBRID_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(DIRECTORY ${PROJECT_BINARY_DIR}/generated/ DESTINATION ${HYBRID_INSTALL_INCLUDEDIR})
install(EXPORT hybridTargets NAMESPACE hybrid:: DESTINATION ${HYBRID_INSTALL_CMAKEDIR})

configure_package_config_file(cmake/hybridConfig.cmake.in ${PROJECT_BINARY_DIR}/hybridConfig.cmake
                              INSTALL_DESTINATION ${HYBRID_INSTALL_CMAKEDIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/hybridConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/hybridConfig.cmake ${PROJECT_BINARY_DIR}/hybridConfigVersion.cmake
        DESTINATION ${HYBRID_INSTALL_CMAKEDIR})
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
